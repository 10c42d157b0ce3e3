#include "scan/io/project/loading/view_loader.h"

#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "scan/base/system/system_memory.h"
#include "scan/io/files/io_error.h"
#include "scan/io/grids/cameras/camera_fit.h"
#include "scan/io/grids/cameras/grid_camera.h"
#include "scan/io/grids/missing_points.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/invalid_depth.h"
#include "scan/io/normals/normal_map.h"
#include "scan/io/project/loading/unorganized_grid.h"
#include "scan/io/project/scan_file.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// The file a view's size comes from.
const fs::path& main_file(const ViewSpec& spec) {
  return spec.depth ? spec.depth->file : *spec.grid;
}

Result<Image> read_matching(const ImageFile& file, const ViewSpec& spec, const RangeView& view) {
  auto image = read_image(file.file, file.size);
  if (!image) return image;
  if (image->width != view.width() || image->height != view.height())
    return bad_input(file.file, "is " + size_text(image->width, image->height) + " pixels, but " +
                                    main_file(spec).string() + " of the same view is " +
                                    size_text(view.width(), view.height()));
  return image;
}

Result<void> check_camera_size(const CameraSpec& camera, int width, int height,
                               const ViewSpec& spec) {
  if (camera.width.value_or(width) == width && camera.height.value_or(height) == height) return {};
  return bad_input(main_file(spec),
                   "is " + size_text(width, height) + ", but the camera of view " + spec.name +
                       " is " +
                       size_text(camera.width.value_or(width), camera.height.value_or(height)));
}

// `points` are those of a grid; null for a depth map, whose camera is given in full.
Camera camera_of(const CameraSpec& spec, int width, int height,
                 const Grid<Eigen::Vector3d>* points) {
  switch (spec.model) {
    case CameraSpec::Model::kPinhole:
      return Camera::pinhole(width, height, spec.intrinsics);
    case CameraSpec::Model::kPinholeGl:
      return Camera::pinhole_gl(width, height, spec.intrinsics);
    case CameraSpec::Model::kOrthographic:
      if (spec.origin || !points)
        return Camera::orthographic(width, height, *spec.origin, *spec.step_u, *spec.step_v,
                                    *spec.view_direction);
      return fit_orthographic(*points, *spec.view_direction);
    case CameraSpec::Model::kSpherical:
      return Camera::spherical(spec.angles);
    case CameraSpec::Model::kRational:
      break;
  }
  return rational_camera(*points, spec.projection, *spec.view_direction);
}

// Claims what the grids of a view will take.
Result<void> claim_memory(const ViewSpec& spec, int width, int height, MemoryBudget& memory) {
  std::size_t pixel = sizeof(double) + 3 * sizeof(float);  // Range, and normals found or given.
  if (spec.confidence) pixel += sizeof(float);
  if (spec.deviation) pixel += sizeof(float);
  if (spec.colour) pixel += sizeof(Colour);
  const std::size_t bytes =
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * pixel;
  if (memory.take(bytes)) return {};
  return Error{ErrorKind::kUnsolvable, main_file(spec).string() + ": view " + spec.name + " of " +
                                           size_text(width, height) + " pixels needs " +
                                           std::to_string((bytes >> 20) + 1) + " MiB of memory, " +
                                           std::to_string(memory.left() >> 20) +
                                           " MiB are left for views; give fewer or smaller ones"};
}

Result<void> load_depth(const ViewSpec& spec, MemoryBudget& memory, LoadedView& loaded) {
  const auto image = read_depth_image(spec.depth->file, spec.depth->size);
  if (!image) return image.error();
  const int width = image->width, height = image->height;
  if (auto size = check_camera_size(*spec.camera, width, height, spec); !size) return size;
  if (spec.camera->model == CameraSpec::Model::kRational)
    return bad_input(spec.depth->file, "a rational camera needs a grid of points, not a depth map");
  if (auto claimed = claim_memory(spec, width, height, memory); !claimed) return claimed;
  RangeView& view = loaded.view;
  view.camera = camera_of(*spec.camera, width, height, nullptr);
  view.range = Grid<double>(width, height, kNoSample);
  const double missing = invalid_depth_value(image->samples);
  if (std::isfinite(missing)) {
    std::ostringstream note;
    note << "view " << spec.name << ": the value " << missing
         << " of its depth map is taken for missing samples";
    loaded.notes.push_back(note.str());
  }
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double value = (*image)(u, v), depth = value * spec.depth->scale;
      if (!(depth > 0.0) || !std::isfinite(depth) || value == missing) continue;
      view.range(u, v) =
          spec.depth->along_ray ? depth / view.camera.ray(u, v).direction.norm() : depth;
    }
  }
  return {};
}

// The residual tells the user whether other views can be projected into this one.
std::string projection_note(const GridCamera& fitted) {
  if (fitted.camera.can_project()) return "";
  return "; no projection fits its grid to half a pixel, so it gives no projective matches";
}

// The camera of a grid, with its points on the rays.
struct GridOnRays {
  GridCamera fitted;
  std::string found;  // How, where nobody gave it.
};

GridOnRays put_on_rays(const ViewSpec& spec, const GridFile& grid) {
  const int width = grid.points.width(), height = grid.points.height();
  const bool direction_known =
      spec.camera &&
      (spec.camera->model != CameraSpec::Model::kOrthographic || spec.camera->view_direction);
  if (direction_known)
    return {
        camera_through_points(grid.points, camera_of(*spec.camera, width, height, &grid.points)),
        ""};
  if (grid.camera) return {camera_through_points(grid.points, *grid.camera), ""};
  const FittedCamera fitted = spec.camera ? fit_orthographic(grid) : fit_camera(grid);
  return {camera_through_points(grid.points, fitted.model), fitted.description};
}

Result<void> load_grid(const ViewSpec& spec, MemoryBudget& memory, LoadedView& loaded) {
  auto grid = read_scan_file(*spec.grid, spec.grid_options);
  if (!grid) return grid.error();
  if (spec.camera)
    if (auto size =
            check_camera_size(*spec.camera, grid->points.width(), grid->points.height(), spec);
        !size)
      return size;
  const auto claim = [&] {
    return claim_memory(spec, grid->points.width(), grid->points.height(), memory);
  };
  if (auto claimed = claim(); !claimed) return claimed;
  GridOnRays on_rays = put_on_rays(spec, *grid);
  const bool has_images = spec.mask || spec.normals || spec.confidence || spec.colour ||
                          spec.deviation;  // On the rows and columns of the file.
  if (!spec.camera && !grid->camera && !has_images && is_unorganized(*grid, on_rays.fitted)) {
    if (auto other = regrid_points(*grid, spec.grid_options.viewpoint)) {
      *grid = *std::move(other);
      if (auto claimed = claim(); !claimed) return claimed;
      on_rays = put_on_rays(spec, *grid);
    }
  }
  for (const std::string& note : grid->notes)
    loaded.notes.push_back("view " + spec.name + ": " + note);
  loaded.assumed_viewpoint = grid->assumed_viewpoint;
  auto& [fitted, found] = on_rays;
  if (!found.empty() || !fitted.camera.can_project())
    loaded.notes.push_back("view " + spec.name + ": camera " +
                           (found.empty() ? "as given" : "found: " + found) +
                           projection_note(fitted));
  loaded.view.camera = std::move(fitted.camera);
  loaded.view.range = std::move(fitted.range);
  loaded.view.confidence = std::move(grid->confidence);
  loaded.view.colours = std::move(grid->colours);
  const bool has_pose = grid->world_from_view || spec.grid_options.shared_frame;
  if (has_pose && spec.pose == PoseKind::kAbsent) {
    loaded.view.world_from_view = grid->world_from_view.value_or(RigidMotion::Identity());
    loaded.view.pose = PoseKind::kGuess;
  }
  if (grid->normals.empty() || spec.normals) return {};
  if (hold_directions({grid->normals.begin(), grid->normals.end()}))
    loaded.normals = StoredNormals{std::move(grid->normals), {}, {}};
  else
    loaded.notes.push_back("view " + spec.name + ": " + kZeroNormalsNote);
  return {};
}

// Notes in `masked` what is not the object.
Result<void> apply_mask(const ViewSpec& spec, RangeView& view, Grid<std::uint8_t>& masked) {
  const auto mask = read_matching(*spec.mask, spec, view);
  if (!mask) return mask.error();
  masked = {view.width(), view.height(), 0};
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      bool object = false;
      for (int c = 0; c < mask->channels; ++c) object |= (*mask)(u, v, c) > 0.0f;
      if (object) continue;
      view.range(u, v) = kNoSample;
      masked(u, v) = 1;
    }
  }
  return {};
}

void mask_normals(const Grid<std::uint8_t>& masked, StoredNormals& normals) {
  for (std::size_t i = 0; i < masked.size(); ++i)
    if (masked[i]) normals.components[i].setConstant(static_cast<float>(kNoSample));
}

Result<void> load_confidence(const ViewSpec& spec, RangeView& view) {
  const auto image = read_matching(*spec.confidence, spec, view);
  if (!image) return image.error();
  if (image->channels != 1) return bad_input(spec.confidence->file, "a confidence has one channel");
  const double scale = image->max_value > 0.0 ? 1.0 / image->max_value : 1.0;
  view.confidence = Grid<float>(view.width(), view.height());
  for (std::size_t i = 0; i < view.confidence.size(); ++i)
    view.confidence[i] = static_cast<float>(image->samples[i] * scale);
  return {};
}

// Images of 16 bits keep the upper eight; grey ones get three equal channels.
Result<void> load_colours(const ViewSpec& spec, RangeView& view) {
  const auto image = read_matching(*spec.colour, spec, view);
  if (!image) return image.error();
  if (!(image->max_value > 0.0))
    return bad_input(spec.colour->file,
                     "colours need an image of integers, 8 or 16 bits a channel");
  const double scale = 255.0 / image->max_value;
  view.colours = Grid<Colour>(view.width(), view.height());
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      for (int c = 0; c < 3; ++c)
        view.colours(u, v)[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(
            std::lround((*image)(u, v, image->channels == 3 ? c : 0) * scale));
  return {};
}

// What is no positive number is unknown. Infinite is what a sample of no weight has.
Result<void> load_deviation(const ViewSpec& spec, RangeView& view) {
  const auto image = read_matching({spec.deviation->file, spec.deviation->size}, spec, view);
  if (!image) return image.error();
  if (image->channels != 1) return bad_input(spec.deviation->file, "a deviation has one channel");
  view.deviation = Grid<float>(view.width(), view.height(), static_cast<float>(kNoSample));
  for (std::size_t i = 0; i < view.deviation.size(); ++i) {
    const auto value = static_cast<float>(image->samples[i] * spec.deviation->scale);
    if (value > 0.0f && view.range[i] == view.range[i]) view.deviation[i] = value;
  }
  return {};
}

Result<void> load_normals(const ViewSpec& spec, LoadedView& loaded) {
  const auto image = read_matching({spec.normals->file, spec.normals->size}, spec, loaded.view);
  if (!image) return image.error();
  auto stored = stored_in_image(*image, *spec.normals, loaded.view);
  if (!stored) return stored.error();
  loaded.normals = std::move(*stored);
  return {};
}

void append(std::vector<std::string>& notes, const std::vector<std::string>& more) {
  notes.insert(notes.end(), more.begin(), more.end());
}

// A confidence that is no number or negative says that the sample is not to be trusted.
void clean_confidence(Grid<float>& confidence) {
  for (float& value : confidence)
    if (!(value >= 0.0f) || !std::isfinite(value)) value = 0.0f;
}

}  // namespace

bool MemoryBudget::take(std::size_t bytes) {
  if (bytes > at_once_) return false;
  std::size_t left = left_;
  while (bytes <= left)
    if (left_.compare_exchange_weak(left, left - bytes)) return true;
  return false;
}

Result<LoadedView> load_view(const ViewSpec& spec) {
  MemoryBudget memory(free_memory());
  return load_view(spec, memory);
}

Result<LoadedView> load_view(const ViewSpec& spec, MemoryBudget& memory) {
  LoadedView loaded;
  loaded.view.name = spec.name;
  loaded.view.world_from_view = spec.world_from_view;
  loaded.view.pose = spec.pose;
  loaded.view.samples = spec.samples;
  Result<void> step =
      spec.depth ? load_depth(spec, memory, loaded) : load_grid(spec, memory, loaded);
  Grid<std::uint8_t> masked;
  if (step && spec.mask) step = apply_mask(spec, loaded.view, masked);
  if (step && spec.confidence) step = load_confidence(spec, loaded.view);
  if (step && spec.colour) step = load_colours(spec, loaded.view);
  if (step && spec.deviation) step = load_deviation(spec, loaded.view);
  if (!step) return step.error();
  if (loaded.view.sample_count() == 0)
    return Error{ErrorKind::kUnsolvable,
                 main_file(spec).string() + ": view " + spec.name +
                     " has no samples: every pixel is without a measurement or masked; leave the "
                     "view out" +
                     (spec.mask ? " or mend its mask, which may be inverted" : "")};
  if (spec.normals) {
    step = load_normals(spec, loaded);
    if (!step) return step.error();
  } else if (loaded.normals) {
    loaded.normals = stored_in_grid(std::move(loaded.normals->components), *spec.grid, loaded.view);
  }
  if (loaded.normals) {
    mask_normals(masked, *loaded.normals);
    append(loaded.notes, loaded.normals->notes);
  }
  clean_confidence(loaded.view.confidence);
  loaded.clipped = find_clipped_ranges(loaded.view);
  return loaded;
}

void set_normals(LoadedView& loaded, const ChosenConvention& chosen) {
  if (!loaded.normals) return;
  append(loaded.notes, apply_convention(*loaded.normals, chosen, loaded.view));
  loaded.normals.reset();
}

}  // namespace relief
