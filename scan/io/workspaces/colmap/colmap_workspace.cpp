#include "scan/io/workspaces/colmap/colmap_workspace.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <string>

#include "scan/base/name_list.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/images/codecs/floats/colmap_array.h"
#include "scan/io/images/image_size.h"
#include "scan/io/workspaces/colmap/colmap_model.h"
#include "scan/io/workspaces/depth_differences.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// Fewer sparse points than this say nothing about a depth map.
constexpr std::size_t kEnoughPoints = 20;
// A depth map whose median difference from the sparse points is larger is named. Those of usable
// maps are a hundredth and less. For a note only.
constexpr double kBadDepth = 0.1;

struct ColmapFolders {
  fs::path root, sparse;
};

std::optional<ColmapFolders> find_colmap_folders(const fs::path& folder) {
  std::error_code code;
  for (const fs::path& root : {folder, folder / "dense", folder / "dense" / "0"})
    for (const fs::path& sparse : {root / "sparse", root / "sparse" / "0"})
      if (has_colmap_model(sparse) && fs::is_directory(root / "stereo", code))
        return ColmapFolders{root, sparse};
  return std::nullopt;
}

// Everything that one image of the model needs to become a view.
struct ColmapSource {
  ColmapFolders folders;
  ColmapModel model;
  std::map<std::uint32_t, const ColmapCamera*> cameras;
  std::map<std::uint32_t, std::vector<Eigen::Vector3d>> seen;  // Points by image.
  ColmapOptions options;
};

// What is told to the user in the end.
struct ColmapFindings {
  std::vector<std::string> without_depth, empty, photometric, bad;
  std::vector<double> differences;
  std::size_t sizes_differ = 0;  // Of images and depth maps.
};

void index_model(ColmapSource& source) {
  for (const ColmapCamera& camera : source.model.cameras) source.cameras[camera.id] = &camera;
  for (const ColmapSighting& sighting : source.model.sightings)
    source.seen[sighting.image_id].push_back(source.model.points[sighting.point]);
}

std::optional<fs::path> existing_file(const fs::path& path) {
  return is_file(path) ? std::optional(path) : std::nullopt;
}

// Both axes have their own ratio: a depth map has a whole number of pixels.
PinholeIntrinsics scaled_intrinsics(const ColmapCamera& camera, int width, int height,
                                    double pixel_centre) {
  const double x = width / static_cast<double>(camera.width);
  const double y = height / static_cast<double>(camera.height);
  const PinholeIntrinsics& k = camera.intrinsics;
  return {k.fx * x, k.fy * y, k.cx * x - pixel_centre, k.cy * y - pixel_centre};
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string percent(double fraction) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", 100.0 * fraction);
  return text;
}

// Compares a depth map with the sparse points that its image saw.
void compare_with_points(const ColmapSource& source, const ColmapImage& image, const Image& depth,
                         const ViewSpec& view, ColmapFindings& findings) {
  const auto seen = source.seen.find(image.id);
  if (seen == source.seen.end()) return;
  const auto differences =
      depth_differences(depth, view.camera->intrinsics, view.world_from_view, seen->second);
  findings.differences.insert(findings.differences.end(), differences.begin(), differences.end());
  if (differences.size() < kEnoughPoints) return;
  if (const double median = median_of(differences); median > kBadDepth)
    findings.bad.push_back(view.name + " (" + percent(median) + ")");
}

// The depth and normals of one kind, `geometric` or `photometric`.
struct ColmapMaps {
  fs::path depth;
  std::optional<fs::path> normals;
  bool geometric = true;
};

std::optional<ColmapMaps> find_maps(const ColmapSource& source, const ColmapImage& image) {
  const fs::path stereo = source.folders.root / "stereo";
  for (const char* kind : {"geometric", "photometric"}) {
    const std::string file = image.name + "." + kind + ".bin";
    if (auto depth = existing_file(stereo / "depth_maps" / file))
      return ColmapMaps{*depth, existing_file(stereo / "normal_maps" / file), *kind == 'g'};
  }
  return std::nullopt;
}

Result<CameraSpec> camera_of_image(const ColmapSource& source, const ColmapImage& image,
                                   const Image& depth) {
  const auto camera = source.cameras.find(image.camera_id);
  if (camera == source.cameras.end())
    return bad_input(source.folders.sparse,
                     "image " + image.name + " has camera " + std::to_string(image.camera_id) +
                         ", which the model lacks; copy cameras and images of one model");
  CameraSpec spec;
  spec.width = depth.width;
  spec.height = depth.height;
  spec.intrinsics =
      scaled_intrinsics(*camera->second, depth.width, depth.height, source.options.pixel_centre);
  return spec;
}

void attach_files(const ColmapSource& source, const ColmapImage& image, const ColmapMaps& maps,
                  ViewSpec& view, ColmapFindings& findings) {
  view.depth = DepthSpec{maps.depth, 1.0, false};
  if (maps.normals)
    view.normals =
        NormalSpec{*maps.normals, NormalEncoding::kUnit, NormalAxes::kOpencv, NormalSpace::kCamera};
  const auto photograph = existing_file(source.folders.root / "images" / image.name);
  if (!photograph) return;
  const auto size = image_size(*photograph);
  if (size && size->width == *view.camera->width && size->height == *view.camera->height)
    view.colour = ImageFile{*photograph};
  else
    ++findings.sizes_differ;
}

// Adds the view of one image, or finds why there is none.
Result<void> add_view_of_image(const ColmapSource& source, const ColmapImage& image,
                               std::set<std::string>& names, ProjectSpec& project,
                               ColmapFindings& findings) {
  const auto maps = find_maps(source, image);
  if (!maps) {
    findings.without_depth.push_back(image.name);
    return {};
  }
  const auto depth = read_colmap_array(maps->depth);
  if (!depth) return depth.error();
  if (depth->channels != 1)
    return bad_input(maps->depth, "a depth map has one channel, this file has three");
  if (std::none_of(depth->samples.begin(), depth->samples.end(),
                   [](float z) { return z > 0.0f && std::isfinite(z); })) {
    findings.empty.push_back(image.name);
    return {};
  }
  const auto camera = camera_of_image(source, image, *depth);
  if (!camera) return camera.error();
  ViewSpec view;
  view.name = free_view_name(fs::path(image.name).replace_extension().string(),
                             [&](const std::string& name) { return names.contains(name); });
  names.insert(view.name);
  view.camera = *camera;
  view.world_from_view = image.world_from_view;
  view.pose = PoseKind::kGuess;
  attach_files(source, image, *maps, view, findings);
  compare_with_points(source, image, *depth, view, findings);
  if (!maps->geometric) findings.photometric.push_back(view.name);
  project.views.push_back(std::move(view));
  return {};
}

void add_list_note(const std::string& what, const std::vector<std::string>& names,
                   std::vector<std::string>& notes) {
  constexpr std::size_t kShown = 20;  // Names in one note.
  if (names.empty()) return;
  notes.push_back(what + " " + name_list(names, kShown));
}

void add_colmap_notes(const ColmapFindings& findings, std::vector<std::string>& notes) {
  add_list_note("left out, no depth map:", findings.without_depth, notes);
  add_list_note("left out, the depth map is empty:", findings.empty, notes);
  add_list_note("photometric depth map, as there is no geometric one:", findings.photometric,
                notes);
  if (findings.sizes_differ > 0)
    notes.push_back(std::to_string(findings.sizes_differ) +
                    " views get no colours: their images have another size than the depth maps");
  if (!findings.differences.empty())
    notes.push_back("depth maps differ from the sparse points by " +
                    percent(median_of(findings.differences)) + " (median of " +
                    std::to_string(findings.differences.size()) + ")");
  add_list_note("depth maps that contradict the sparse points (median difference):", findings.bad,
                notes);
}

}  // namespace

bool is_colmap_workspace(const fs::path& folder) { return find_colmap_folders(folder).has_value(); }

Result<ProjectSpec> read_colmap_workspace(const fs::path& folder, const ColmapOptions& options) {
  const auto folders = find_colmap_folders(folder);
  if (!folders)
    return bad_input(folder,
                     "no workspace of COLMAP: it needs sparse/ with cameras and images (.bin or "
                     ".txt) and stereo/depth_maps, which colmap patch_match_stereo writes");
  auto model = read_colmap_model(folders->sparse);
  if (!model) return model.error();
  ColmapSource source{*folders, std::move(*model), {}, {}, options};
  std::sort(source.model.images.begin(), source.model.images.end(),
            [](const auto& a, const auto& b) { return natural_less(a.name, b.name); });
  index_model(source);
  ProjectSpec project;
  project.unit = "units";
  ColmapFindings findings;
  std::set<std::string> names;
  for (const ColmapImage& image : source.model.images)
    if (auto added = add_view_of_image(source, image, names, project, findings); !added)
      return added.error();
  if (project.views.empty())
    return bad_input(folders->root / "stereo" / "depth_maps",
                     "none of the " + std::to_string(source.model.images.size()) +
                         " images of the model has a depth map with depths "
                         "(NAME.geometric.bin); run colmap patch_match_stereo");
  add_colmap_notes(findings, project.notes);
  return project;
}

}  // namespace relief
