#include <algorithm>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <sstream>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/image_size.h"
#include "scan/io/project/guess/folder_guess.h"
#include "scan/io/project/no_project.h"
#include "scan/io/project/options_of_input.h"
#include "scan/io/project/poses/poses_of_scans.h"
#include "scan/io/project/ptx_views.h"
#include "scan/io/project/scan_file.h"
#include "scan/io/project/view_spec.h"
#include "scan/io/workspaces/colmap/colmap_workspace.h"
#include "scan/io/workspaces/meshlab_mlp.h"
#include "scan/io/workspaces/pose_beside.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/nerf_transforms.h"
#include "scan/io/workspaces/rgbd/rgbd_folder.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// Formats that say nothing of their unit.
constexpr const char* kUnknownUnit = "units";

std::string unused_name(const ProjectSpec& project, const std::string& stem,
                        const std::string& file_name) {
  const bool taken = std::any_of(project.views.begin(), project.views.end(),
                                 [&](const auto& other) { return other.name == stem; });
  return taken ? file_name : stem;
}

// One view for each scan of a file.
Result<void> add_scans(const fs::path& file, const ReadProjectOptions& options,
                       ProjectSpec& project) {
  const auto scans = list_scans(file);
  if (!scans) return scans.error();
  const bool alone = scans->size() == 1;
  const auto pose = alone ? pose_beside(file) : Result<std::optional<RigidMotion>>(std::nullopt);
  if (!pose) return pose.error();
  const std::string stem = unused_name(project, file.stem().string(), file.filename().string());
  for (const GridOptions& scan : *scans) {
    ViewSpec view;
    view.name = alone ? stem : stem + "-" + std::to_string(scan.scan + 1);
    view.grid = file;
    view.grid_options = scan;
    view.grid_options.viewpoint = options.viewpoint;
    view.grid_options.ignore_pose = options.ignore_viewpoints;
    view.grid_options.shared_frame = options.shared_frame;
    if (*pose) {
      view.world_from_view = **pose;
      view.pose = PoseKind::kGuess;
    }
    project.views.push_back(std::move(view));
  }
  return {};
}

Result<ProjectSpec> spec_of_scans(const std::vector<fs::path>& files,
                                  const ReadProjectOptions& options) {
  ProjectSpec project;
  project.unit = kUnknownUnit;
  // PTX and E57 hold metres.
  if (std::all_of(files.begin(), files.end(), [](const fs::path& file) {
        return kind_of_scan_file(file) == ScanFileKind::kScans;
      }))
    project.unit = "m";
  for (const auto& file : files)
    if (auto added = add_scans(file, options, project); !added) return added.error();
  return project;
}

Result<ProjectSpec> parse_project(const std::string& text, const fs::path& path,
                                  const RgbdOptions& options) {
  const std::string ending = lower_ending(path);
  if (ending == ".json")
    return looks_like_nerf_transforms(text) ? parse_nerf_transforms(text, path, options)
                                            : parse_scan_json(text, path, options.intrinsics);
  auto project = ending == ".aln"   ? parse_meshlab_aln(text, path)
                 : ending == ".mlp" ? parse_meshlab_mlp(text, path)
                                    : parse_stanford_conf(text, path);
  if (project) project->unit = kUnknownUnit;
  return project;
}

Result<ProjectSpec> spec_of_file(const fs::path& path, const ReadProjectOptions& options) {
  if (belongs_to_depth_maps(path)) return why_no_project(path);
  if (is_project_file(path)) {
    auto text = read_file(path);
    if (!text) return text.error();
    auto project = parse_project(*text, path, {options.intrinsics, options.depth_scale});
    if (project) project->file = path;
    return project;
  }
  if (has_scan_ending(path)) return spec_of_scans({path}, options);
  return why_no_project(path);
}

// What a folder without a project file holds.
struct FolderContent {
  std::vector<fs::path> projects;  // .conf, .aln and .mlp
  std::vector<fs::path> grids, points;
  std::vector<fs::path> texts;     // That may hold points.
  std::vector<std::string> notes;  // On files that are skipped.
};

// Text files that may be anything (.txt, .csv) count as points only where they are named, or begin
// with points in a folder that has nothing else to read.
bool is_surely_points(const fs::path& path) {
  const std::string ending = lower_ending(path);
  return ending != ".txt" && ending != ".csv";
}

Result<FolderContent> look_into(const fs::path& folder) {
  FolderContent content;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    const fs::path& path = entry.path();
    if (is_hidden(path)) continue;
    if (is_project_file(path)) {
      if (lower_ending(path) != ".json") content.projects.push_back(path);
      continue;
    }
    const ScanFileKind kind = kind_of_scan_file(path);
    if (kind == ScanFileKind::kOther)
      content.notes.push_back("skipped " + path.string() +
                              ": it holds no points, for want of a field x");
    if (kind == ScanFileKind::kGrid || kind == ScanFileKind::kScans) content.grids.push_back(path);
    if (kind == ScanFileKind::kPoints)
      (is_surely_points(path) ? content.points : content.texts).push_back(path);
  }
  if (code) return bad_input(folder, "cannot list the folder: " + code.message());
  for (auto* files : {&content.projects, &content.grids, &content.points, &content.texts})
    sort_naturally(*files);
  std::ranges::sort(content.notes);
  return content;
}

// Whether one of the first lines of a text, after a heading, is three numbers or more. Poses and
// calibrations are shorter.
bool begins_with_points(const fs::path& path) {
  constexpr int kLines = 8;                // Headings of points have fewer.
  constexpr std::uintmax_t kLeast = 1024;  // [bytes]
  std::error_code code;
  if (const auto size = fs::file_size(path, code); code || size < kLeast) return false;
  std::ifstream file(path);
  std::string line;
  for (int i = 0; i < kLines && read_line(file, line); ++i) {
    std::istringstream words(with_blanks(line, ",;"));
    double x = 0.0, y = 0.0, z = 0.0;
    if (words >> x >> y >> z) return true;
  }
  return false;
}

// Tells the user what a folder was taken for.
Result<ProjectSpec> read_as(const char* what, const fs::path& folder, Result<ProjectSpec> project) {
  if (project) project->notes.insert(project->notes.begin(), folder.string() + ": read as " + what);
  return project;
}

std::size_t count_images(const fs::path& folder) {
  const auto files = files_in(folder);
  return static_cast<std::size_t>(std::ranges::count_if(files, has_depth_image_ending));
}

// Where scans may lie instead, for the user.
std::string other_folders(const fs::path& folder) {
  const auto folders = folders_in(folder);
  const auto most = std::ranges::max_element(folders, {}, count_images);
  if (most == folders.end() || count_images(*most) == 0)
    return "name the folder that holds these, above it or in it";
  return "its folder " + most->filename().string() + " holds images (" +
         std::to_string(count_images(*most)) + "): name that";
}

Error no_project_in(const fs::path& folder) {
  if (const std::size_t images = count_images(folder))
    return bad_input(folder,
                     "holds images (" + std::to_string(images) +
                         "), but neither intrinsics nor a layout that tells depth maps: 'relief "
                         "init " +
                         folder.string() +
                         " --intrinsics FX FY CX CY --depth-scale N' writes a scan.json for them; "
                         "a folder with depth/ and a calibration or trajectory is read as it is");
  return bad_input(folder,
                   "no scan.json, no file of scans (.ply .pcd .ptx .e57 .xyz .pts .obj .stl "
                   ".vtp), no depth maps with their lists or poses and no COLMAP workspace in "
                   "it; " +
                       other_folders(folder) + ", or try 'relief init'");
}

// The only project of a folder. Scans beside it that it does not name are told.
Result<ProjectSpec> spec_of_project_in(const fs::path& folder, const FolderContent& content,
                                       const ReadProjectOptions& options) {
  const fs::path& file = content.projects.front();
  auto project = spec_of_file(file, options);
  if (!project) return project;
  std::error_code code;
  std::vector<std::string> others;
  for (const auto* files : {&content.grids, &content.points})
    for (const fs::path& scan : *files)
      if (std::ranges::none_of(project->views, [&](const ViewSpec& view) {
            return view.grid && fs::equivalent(*view.grid, scan, code);
          }))
        others.push_back(scan.filename().string());
  if (!others.empty())
    project->notes.push_back(folder.string() + ": views are those that " +
                             file.filename().string() + " names; " + std::to_string(others.size()) +
                             " more files of scans are left out, as " + others.front());
  return project;
}

// Images that no layout tells apart, by the intrinsics given or those of a calibration beside them.
Result<ProjectSpec> spec_of_images(const fs::path& folder, ReadProjectOptions options) {
  if (options.intrinsics)
    return read_as("depth maps, by the intrinsics given", folder, read_depth_maps(folder, options));
  auto calibration = find_calibration(folder);
  if (calibration && !*calibration) calibration = find_calibration_beside(folder);
  if (!calibration) return calibration.error();
  if (!*calibration || !(*calibration)->intrinsics) return no_project_in(folder);
  options.intrinsics = (*calibration)->intrinsics;
  if (!options.depth_scale) options.depth_scale = (*calibration)->depth_scale;
  auto project = read_as("depth maps, by the calibration beside them", folder,
                         read_depth_maps(folder, options));
  if (project)
    project->notes.insert(project->notes.end(), (*calibration)->notes.begin(),
                          (*calibration)->notes.end());
  return project;
}

Result<ProjectSpec> spec_of_folder(const fs::path& folder, const ReadProjectOptions& options) {
  std::error_code code;
  if (fs::exists(folder / "scan.json", code)) return spec_of_file(folder / "scan.json", options);
  if (is_nerf_folder(folder))
    return read_as("the frames of transforms.json", folder,
                   spec_of_file(folder / "transforms.json", options));
  if (is_colmap_workspace(folder))
    return read_as("a COLMAP workspace", folder, read_colmap_workspace(folder));
  if (is_rgbd_folder(folder))
    return read_as("a folder of depth maps", folder,
                   read_rgbd_folder(folder, {options.intrinsics, options.depth_scale}));
  auto content = look_into(folder);
  if (!content) return content.error();
  if (content->projects.empty() && content->grids.empty() && content->points.empty() &&
      count_images(folder) == 0)
    std::ranges::copy_if(content->texts, std::back_inserter(content->points), begins_with_points);
  if (content->projects.size() == 1) return spec_of_project_in(folder, *content, options);
  if (content->grids.empty() && content->points.empty()) {
    return count_images(folder) > 0 ? spec_of_images(folder, options)
                                    : Result<ProjectSpec>(no_project_in(folder));
  }
  auto project = spec_of_scans(content->grids.empty() ? content->points : content->grids, options);
  if (project) {
    project->notes.insert(project->notes.end(), content->notes.begin(), content->notes.end());
    if (content->projects.empty()) take_poses_of_folder(folder, *project);
  }
  if (project && !content->projects.empty()) {
    std::string names;
    for (const fs::path& path : content->projects) names += " " + path.filename().string();
    project->notes.push_back(folder.string() +
                             ": poses of none of its projects are taken, since "
                             "there are several; name one of them:" +
                             names);
  }
  if (!project || content->grids.empty())
    return read_as("points and meshes without sensor grids", folder, std::move(project));
  for (const fs::path& path : content->points)
    project->notes.push_back("skipped " + path.string() +
                             ": it holds no sensor grid, as other files beside it do");
  return project;
}

}  // namespace

bool is_project_file(const fs::path& path) {
  const std::string ending = lower_ending(path);
  return ending == ".json" || ending == ".conf" || ending == ".aln" || ending == ".mlp";
}

Result<ProjectSpec> read_project_spec(const fs::path& path, const ReadProjectOptions& options) {
  std::error_code code;
  if (!fs::exists(path, code)) return bad_input(path, "no such file or folder");
  auto project =
      fs::is_directory(path, code) ? spec_of_folder(path, options) : spec_of_file(path, options);
  if (!project) return project;
  if (auto applied = apply_options_of_input(options, path, *project); !applied)
    return applied.error();
  complete_ptx_views(*project);
  return project;
}

}  // namespace relief
