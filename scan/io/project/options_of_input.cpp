#include "scan/io/project/options_of_input.h"

#include <algorithm>
#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/project/scan_file.h"
#include "scan/io/workspaces/colmap/colmap_workspace.h"
#include "scan/io/workspaces/rgbd/nerf_transforms.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// `count` numbers and nothing else, from a small text file.
Result<std::vector<double>> read_numbers(const fs::path& path, std::size_t count,
                                         const std::string& expected) {
  auto text = read_file(path);
  if (!text) return text.error();
  std::istringstream words(*text);
  std::vector<double> numbers;
  for (double number; words >> number;) numbers.push_back(number);
  if (numbers.size() != count || !words.eof())
    return bad_input(
        path, "expected " + expected + "; read " + std::to_string(numbers.size()) + " numbers");
  return numbers;
}

Result<CameraSpec> read_fc(const fs::path& path) {
  const auto numbers = read_numbers(path, 4, "the four numbers fx fy cx cy");
  if (!numbers) return numbers.error();
  CameraSpec camera;
  camera.model = CameraSpec::Model::kPinholeGl;
  camera.intrinsics = {(*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]};
  if (!(camera.intrinsics.fx > 0.0 && camera.intrinsics.fy > 0.0))
    return bad_input(path, "the focal lengths fx and fy must be positive");
  return camera;
}

// Whether a view may have points without a grid. The header of its file is read.
bool needs_viewpoint(const ViewSpec& view) {
  if (!view.grid) return false;
  const ScanFileKind kind = kind_of_scan_file(*view.grid);
  return kind == ScanFileKind::kPoints || kind == ScanFileKind::kScans;
}

void apply_viewpoint(const Eigen::Vector3d& viewpoint, const std::string& place,
                     ProjectSpec& project) {
  std::size_t used = 0, kept = 0;
  for (ViewSpec& view : project.views) {
    if (!needs_viewpoint(view)) continue;
    auto& own = view.grid_options.viewpoint;
    if (!own) own = viewpoint;
    ++(*own == viewpoint ? used : kept);
  }
  if (kept > 0)
    project.notes.push_back("--viewpoint is not used for " + std::to_string(kept) + " of " +
                            std::to_string(project.views.size()) + " views: " + place +
                            " has a viewpoint for them");
  else if (used == 0)
    project.notes.push_back("--viewpoint is not used: " + place + " has no points without a grid");
}

void ignore_poses_of_files(const std::string& place, ProjectSpec& project) {
  bool used = false;
  for (ViewSpec& view : project.views) {
    view.grid_options.ignore_pose |= view.grid.has_value();
    used |= view.grid.has_value();
  }
  if (!used)
    project.notes.push_back("--ignore-viewpoint is not used: " + place +
                            " names no files of scans");
}

Result<void> apply_fc(const fs::path& file, const std::string& place, ProjectSpec& project) {
  const auto camera = read_fc(file);
  if (!camera) return camera.error();
  bool used = false;
  for (ViewSpec& view : project.views) {
    if (!view.grid || view.camera) continue;
    view.camera = *camera;
    used = true;
  }
  if (!used)
    project.notes.push_back("--fc is not used: " + place + " has no grid without a camera");
  return {};
}

bool has_intrinsics(const ViewSpec& view, const PinholeIntrinsics& intrinsics) {
  return view.camera && view.camera->intrinsics.fx == intrinsics.fx &&
         view.camera->intrinsics.fy == intrinsics.fy;
}

// A scan.json and a COLMAP workspace tell the scale of their depth maps.
bool tells_scale(const ProjectSpec& project, const fs::path& path) {
  if (project.file.empty()) return is_colmap_workspace(path);
  const auto text = read_file(project.file);
  return text && !looks_like_nerf_transforms(*text);
}

void note_unused_intrinsics(const PinholeIntrinsics& intrinsics, const std::string& place,
                            ProjectSpec& project) {
  if (std::ranges::any_of(project.views,
                          [&](const ViewSpec& view) { return has_intrinsics(view, intrinsics); }))
    return;
  project.notes.push_back("--intrinsics are not used: " +
                          (lower_ending(project.file) == ".json"
                               ? "in " + place + " no focal length is 0"
                               : place + " has no depth maps without a camera"));
}

void note_unused_scale(const fs::path& path, const std::string& place, ProjectSpec& project) {
  if (std::ranges::none_of(project.views,
                           [](const ViewSpec& view) { return view.depth.has_value(); }))
    project.notes.push_back("--depth-scale is not used: " + place + " has no depth maps");
  else if (tells_scale(project, path))
    project.notes.push_back("--depth-scale is not used: " + place +
                            " tells the scale of its depth maps");
}

}  // namespace

Result<void> apply_options_of_input(const ReadProjectOptions& options, const fs::path& path,
                                    ProjectSpec& project) {
  const std::string place = (project.file.empty() ? path : project.file).string();
  if (options.viewpoint) apply_viewpoint(*options.viewpoint, place, project);
  if (options.ignore_viewpoints) ignore_poses_of_files(place, project);
  if (options.intrinsics) note_unused_intrinsics(*options.intrinsics, place, project);
  if (options.depth_scale) note_unused_scale(path, place, project);
  if (!options.fc_file.empty()) return apply_fc(options.fc_file, place, project);
  return {};
}

}  // namespace relief
