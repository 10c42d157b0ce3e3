#include <algorithm>
#include <cctype>
#include <sstream>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"
#include "scan/io/grids/grid_file.h"
#include "scan/io/project/view_spec.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// Formats that say nothing of their unit.
constexpr const char* kUnknownUnit = "units";

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

// The pose in a `.xf` file beside a grid file: four rows of four numbers.
Result<void> read_pose_beside(ViewSpec& view) {
  fs::path path = *view.grid;
  path.replace_extension(".xf");
  std::error_code code;
  if (!fs::exists(path, code)) return {};
  const auto numbers = read_numbers(path, 16, "four rows of four numbers");
  if (!numbers) return numbers.error();
  const Eigen::Matrix4d matrix =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers->data());
  const auto motion = rigid_motion_from_matrix(matrix, path.string() + ": the pose");
  if (!motion) return motion.error();
  view.world_from_view = *motion;
  view.pose = PoseKind::kGuess;
  return {};
}

Result<ProjectSpec> spec_of_grids(const std::vector<fs::path>& files) {
  ProjectSpec project;
  project.unit = kUnknownUnit;
  for (const auto& file : files) {
    ViewSpec view;
    view.name = file.stem().string();
    const bool taken = std::any_of(project.views.begin(), project.views.end(),
                                   [&](const auto& other) { return other.name == view.name; });
    if (taken) view.name = file.filename().string();
    view.grid = file;
    if (auto pose = read_pose_beside(view); !pose) return pose.error();
    project.views.push_back(std::move(view));
  }
  return project;
}

Result<ProjectSpec> spec_of_file(const fs::path& path) {
  if (has_grid_ending(path)) return spec_of_grids({path});
  if (path.extension() != ".json" && path.extension() != ".conf" && path.extension() != ".aln")
    return bad_input(path,
                     "unknown project format '" + path.extension().string() +
                         "'; use a scan.json, a .conf, an .aln, a .ply or .pcd grid, or a folder");
  auto text = read_file(path);
  if (!text) return text.error();
  if (path.extension() == ".json") return parse_scan_json(*text, path);
  auto project = path.extension() == ".aln" ? parse_meshlab_aln(*text, path)
                                            : parse_stanford_conf(*text, path);
  if (project) project->unit = kUnknownUnit;
  return project;
}

Result<ProjectSpec> spec_of_folder(const fs::path& folder) {
  std::error_code code;
  if (fs::exists(folder / "scan.json", code)) return spec_of_file(folder / "scan.json");
  std::vector<fs::path> grids, configurations;
  std::vector<std::string> notes;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    const fs::path& path = entry.path();
    if (path.extension() == ".conf") configurations.push_back(path);
    if (!has_grid_ending(path)) continue;
    if (is_grid_file(path))
      grids.push_back(path);
    else
      notes.push_back("skipped " + path.string() + ": it holds no sensor grid");
  }
  if (code) return bad_input(folder, "cannot list the folder: " + code.message());
  if (configurations.size() == 1) return spec_of_file(configurations.front());
  if (grids.empty())
    return bad_input(folder, "no scan.json and no scan grid (.ply with range_grid, .pcd) in it");
  std::sort(grids.begin(), grids.end());
  std::sort(notes.begin(), notes.end());
  auto project = spec_of_grids(grids);
  if (project) project->notes = notes;
  return project;
}

}  // namespace

Result<ProjectSpec> read_project_spec(const fs::path& path, const fs::path& fc_file) {
  std::error_code code;
  if (!fs::exists(path, code)) return bad_input(path, "no such file or folder");
  auto project = fs::is_directory(path, code) ? spec_of_folder(path) : spec_of_file(path);
  if (!project || fc_file.empty()) return project;
  const auto camera = read_fc(fc_file);
  if (!camera) return camera.error();
  for (auto& view : project->views)
    if (view.grid && !view.camera) view.camera = *camera;
  return project;
}

}  // namespace relief
