#include "scan/io/project/poses/poses_of_scans.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scan/io/files/file_ending.h"
#include "scan/io/grids/pcd_header.h"
#include "scan/io/workspaces/rgbd/poses/frame_poses.h"
#include "scan/io/workspaces/rgbd/poses/named_pose_file.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// Files that hold one scan in the frame of its sensor. Texts of points could be taken for poses,
// PTX and E57 tell poses themselves, and those beside clouds of a lidar are often of its car. Depth
// maps hold no pose.
bool may_lack_pose(const ViewSpec& view) {
  if (view.depth) return view.pose == PoseKind::kAbsent;
  constexpr std::array<std::string_view, 3> kEndings = {".pcd", ".ply", ".xyz"};
  return view.grid && view.pose == PoseKind::kAbsent && !view.grid_options.shared_frame &&
         std::ranges::find(kEndings, lower_ending(*view.grid)) != kEndings.end();
}

std::vector<double> viewpoint_of(const ViewSpec& view) {
  if (!view.grid || view.grid_options.ignore_pose || lower_ending(*view.grid) != ".pcd") return {};
  const auto header = read_pcd_header(*view.grid, /*organized=*/false);
  return header ? header->viewpoint : std::vector<double>();
}

// One in all files is a turn of the axes, and no pose.
bool have_viewpoints(const std::vector<ViewSpec>& views) {
  std::set<std::vector<double>> viewpoints;
  for (const ViewSpec& view : views) viewpoints.insert(viewpoint_of(view));
  return viewpoints.size() > 1;
}

// Empty: they are taken.
std::string why_not_taken(const std::vector<ViewSpec>& views) {
  if (!std::ranges::all_of(views, may_lack_pose))
    return "some scans have poses of their own, or lie in one frame";
  return have_viewpoints(views) ? "the scans have poses of their own, their VIEWPOINT; with "
                                  "--ignore-viewpoint this file is taken instead"
                                : "";
}

}  // namespace

void take_poses_of_folder(const fs::path& folder, ProjectSpec& project) {
  if (const std::string why = why_not_taken(project.views); !why.empty()) {
    for (const fs::path& file : files_named_as_poses(folder))
      project.notes.push_back(file.string() + ": is not read: " + why);
    return;
  }
  RgbdFrames scans;
  for (const ViewSpec& view : project.views) {
    RgbdFrame& scan = scans.frames.emplace_back();
    scan.name = view.name;
    scan.depth = view.depth ? view.depth->file : *view.grid;
  }
  const auto poses = find_frame_poses(folder, scans, project.notes);
  if (!poses) {
    project.notes.push_back("poses are not taken: " + poses.error().message);
    return;
  }
  for (std::size_t i = 0; i < project.views.size(); ++i) {
    if (!(*poses)[i]) continue;
    project.views[i].world_from_view = (*poses)[i]->world_from_view;
    project.views[i].pose = PoseKind::kGuess;
  }
}

}  // namespace relief
