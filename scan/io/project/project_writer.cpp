#include <algorithm>
#include <optional>
#include <set>

#include <nlohmann/json.hpp>

#include "relief/io/project_io.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/grids/pcd_grid_writer.h"
#include "scan/io/grids/ply_grid_writer.h"
#include "scan/io/images/image_io.h"
#include "scan/io/project/json/camera_json_private.h"
#include "scan/io/project/json/spec_json_private.h"
#include "scan/io/project/project_files.h"
#include "scan/io/project/view_spec.h"
#include "scan/io/workspaces/rgbd/nerf_transforms.h"

namespace relief {

namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

Image depth_image(const RangeView& view, double back) {
  Image image(view.width(), view.height(), 1);
  for (std::size_t i = 0; i < view.range.size(); ++i)
    image.samples[i] =
        view.range[i] == view.range[i] ? static_cast<float>(view.range[i] + back) : 0;
  return image;
}

// In opencv axes: for pinhole cameras the components of the view frame, else those of its sensor.
Image normal_image(const RangeView& view) {
  Image image(view.width(), view.height(), 3);
  const bool flip_z = view.camera.model() == Camera::Model::kPinholeGl;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_normal(u, v)) continue;
      const Eigen::Vector3f& normal = view.normals(u, v);
      image(u, v, 0) = normal.x();
      image(u, v, 1) = normal.y();
      image(u, v, 2) = flip_z ? -normal.z() : normal.z();
    }
  }
  return image;
}

Result<void> write_tiff(const Image& image, const fs::path& path) {
  const auto bytes = encode_tiff(image);
  if (!bytes) return cannot_write(path, bytes.error().message);
  return write_file(path, *bytes);
}

Result<void> write_colours(const RangeView& view, const fs::path& folder, const std::string& stem,
                           json& entry) {
  if (view.colours.empty()) return {};
  Image image(view.width(), view.height(), 3, 255.0);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      for (int c = 0; c < 3; ++c) image(u, v, c) = view.colours(u, v)[static_cast<std::size_t>(c)];
  const fs::path path = folder / (stem + "_color.png");
  entry["color"] = {{"file", path.filename().string()}};
  const auto bytes = encode_png(image);
  if (!bytes) return cannot_write(path, bytes.error().message);
  return write_file(path, *bytes);
}

Result<void> write_depth_view(const RangeView& view, const fs::path& folder,
                              const std::string& stem, bool declare_normals, json& entry) {
  const double back = step_back(view);
  entry["depth"] = {{"file", stem + "_depth.tiff"}, {"scale", 1.0}, {"kind", "z"}};
  entry["camera"] = camera_json(view);
  if (auto depth = write_tiff(depth_image(view, back), folder / (stem + "_depth.tiff")); !depth)
    return depth;
  if (view.has_normals()) {
    entry["normals"] = {{"file", stem + "_normal.tiff"}, {"encoding", "unit"}};
    if (declare_normals) {
      entry["normals"]["axes"] = "opencv";
      entry["normals"]["space"] = "camera";
    }
    if (auto n = write_tiff(normal_image(view), folder / (stem + "_normal.tiff")); !n) return n;
  }
  if (auto colours = write_colours(view, folder, stem, entry); !colours) return colours;
  if (view.confidence.empty()) return {};
  Image confidence(view.width(), view.height(), 1);
  std::copy(view.confidence.begin(), view.confidence.end(), confidence.samples.begin());
  entry["confidence"] = {{"file", stem + "_confidence.tiff"}};
  return write_tiff(confidence, folder / (stem + "_confidence.tiff"));
}

// Zero where it is unknown.
Result<void> write_deviation(const RangeView& view, const fs::path& folder, const std::string& stem,
                             json& entry) {
  if (view.deviation.empty()) return {};
  Image image(view.width(), view.height(), 1);
  for (std::size_t i = 0; i < view.deviation.size(); ++i)
    if (view.deviation[i] > 0.0f) image.samples[i] = view.deviation[i];
  entry["deviation"] = {{"file", stem + "_deviation.tiff"}, {"scale", 1.0}};
  return write_tiff(image, folder / (stem + "_deviation.tiff"));
}

Result<void> write_grid_view(const RangeView& view, const fs::path& folder, const std::string& stem,
                             GridFormat format, json& entry) {
  const std::string file = stem + (format == GridFormat::kPcd ? ".pcd" : ".ply");
  entry["grid"] = {{"file", file}};
  const json camera = camera_json(view);
  if (!camera.is_null()) entry["camera"] = camera;
  return write_file(folder / file,
                    format == GridFormat::kPcd ? encode_pcd_grid(view) : encode_ply_grid(view));
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

// Says from where the points of a view were taken as seen: other views of the set may have told it.
void set_viewpoint_json(const ScanProject& project, const std::string& view, json& entry) {
  if (std::ranges::find(project.seen_from_origin, view) != project.seen_from_origin.end())
    entry["grid"]["viewpoint"] = {0.0, 0.0, 0.0};
}

// What options of input tell of a view and its entry does not: it is read without them later.
void set_options_json(const ViewSpec& view, const fs::path& folder, json& entry) {
  const json told = view_json(view, folder);
  if (told.contains("grid")) entry["grid"] = told["grid"];
  const bool draft = entry.contains("camera") && (entry["camera"].value("fx", 1.0) == 0.0 ||
                                                  entry["camera"].value("fy", 1.0) == 0.0);
  if (told.contains("camera") && (draft || !entry.contains("camera")))
    entry["camera"] = told["camera"];
}

// A scan.json whose file names are relative to `file` instead of `source`, with only the views of
// `project` and their poses.
Result<json> updated_document(const ScanProject& project, const fs::path& source,
                              const ReadProjectOptions& options, const fs::path& file) {
  const auto spec = read_project_spec(source, options);
  if (!spec) return spec.error();
  auto text = read_file(source);
  if (!text) return text.error();
  json document = json::parse(*text, nullptr, true, /*ignore_comments=*/true);
  json views = json::array();
  for (json& entry : document["views"]) {
    const RangeView* view = find_view(project, entry["name"].get<std::string>());
    if (!view) continue;
    for (const char* key :
         {"depth", "grid", "normals", "mask", "confidence", "color", "deviation"}) {
      if (!entry.contains(key)) continue;
      json& name = entry[key]["file"];
      name = path_from(folder_of(source) / name.get<std::string>(), folder_of(file)).string();
    }
    if (const auto told = std::ranges::find(spec->views, view->name, &ViewSpec::name);
        told != spec->views.end())
      set_options_json(*told, folder_of(file), entry);
    set_viewpoint_json(project, view->name, entry);
    set_pose_json(entry, view->world_from_view, view->pose);
    views.push_back(std::move(entry));
  }
  document["views"] = std::move(views);
  return document;
}

// The same for sources of other formats.
json document_of_spec(const ScanProject& project, const ProjectSpec& spec, const fs::path& file) {
  json document = empty_project_json(project.unit);
  for (const auto& source : spec.views) {
    const RangeView* view = find_view(project, source.name);
    if (!view) continue;
    json entry = view_json(source, folder_of(file));
    set_viewpoint_json(project, view->name, entry);
    set_pose_json(entry, view->world_from_view, view->pose);
    document["views"].push_back(std::move(entry));
  }
  return document;
}

// The scan.json that a source stands for, if it is one. The frames of nerfstudio are .json as well.
std::optional<fs::path> scan_json_of(const fs::path& source) {
  std::error_code code;
  if (lower_ending(source) == ".json") {
    const auto text = read_file(source);
    return text && looks_like_nerf_transforms(*text) ? std::nullopt : std::optional(source);
  }
  if (fs::is_directory(source, code) && fs::exists(source / "scan.json", code))
    return source / "scan.json";
  return std::nullopt;
}

}  // namespace

Result<void> write_project(const std::vector<RangeView>& views, const std::string& unit,
                           const fs::path& folder, const Context& context,
                           const WriteProjectOptions& options) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) return cannot_write(folder, "cannot create the folder: " + code.message());
  json document = empty_project_json(unit);
  std::set<std::string> stems;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const RangeView& view = views[i];
    const double fraction = static_cast<double>(i) / static_cast<double>(views.size());
    if (!report_progress(context.progress, fraction, "writing views"))
      return Error{ErrorKind::kInterrupted, folder.string() + ": writing was interrupted"};
    json entry = {{"name", view.name}};
    const std::string stem = view_file_stem(view.name, stems);
    const bool grid = options.grids || needs_grid_file(view);
    auto written = grid ? write_grid_view(view, folder, stem, options.grid_format, entry)
                        : write_depth_view(view, folder, stem, options.declare_normals, entry);
    if (written) written = write_deviation(view, folder, stem, entry);
    if (!written) return written;
    set_samples_json(entry, view.samples);
    set_pose_json(entry, view.world_from_view, view.pose);
    document["views"].push_back(std::move(entry));
  }
  // Last: the folder is a project only when all it names is there.
  return write_file(folder / "scan.json", document.dump(1) + "\n");
}

Result<void> write_project(const ScanProject& project, const fs::path& folder,
                           const Context& context, const WriteProjectOptions& options) {
  return write_project(project.views, project.unit, folder, context, options);
}

Result<void> write_project_poses(const ScanProject& project, const fs::path& source,
                                 const ReadProjectOptions& source_options, const fs::path& file) {
  if (const auto scan_json = scan_json_of(source)) {
    const auto document = updated_document(project, *scan_json, source_options, file);
    if (!document) return document.error();
    return write_file(file, document->dump(1) + "\n");
  }
  const auto spec = read_project_spec(source, source_options);
  if (!spec) return spec.error();
  return write_file(file, document_of_spec(project, *spec, file).dump(1) + "\n");
}

}  // namespace relief
