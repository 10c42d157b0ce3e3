#include "scan/io/project/poses/poses_of_views.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <string_view>

#include "relief/io/project_io.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/workspaces/rgbd/nerf_transforms.h"
#include "scan/io/workspaces/rgbd/poses/frame_poses.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

bool is_json(const fs::path& path) { return lower_ending(path) == ".json"; }

// Whether a JSON has the views of a scan.json, of a truth or of a report.
bool lists_views(const fs::path& path) {
  const auto text = read_file(path);
  return !text || text->find("\"views\"") != std::string::npos;
}

Result<FramePoses> poses_in_list(const fs::path& path, const std::vector<RgbdFrame>& views) {
  const auto list = read_poses(path);
  if (!list) return list.error();
  std::map<std::string, RigidMotion> by_name;
  for (const NamedPose& pose : *list) by_name.emplace(pose.name, pose.world_from_view);
  FramePoses poses(views.size());
  for (std::size_t i = 0; i < views.size(); ++i)
    if (const auto found = by_name.find(views[i].name); found != by_name.end())
      poses[i].emplace().world_from_view = found->second;
  return poses;
}

}  // namespace

bool holds_poses_alone(const fs::path& path) {
  constexpr std::array<std::string_view, 5> kTrajectories = {".log", ".tum", ".traj", ".freiburg",
                                                             ".npy"};
  const std::string ending = lower_ending(path);
  if (std::ranges::find(kTrajectories, ending) != kTrajectories.end()) return true;
  if (ending == ".txt" || ending == ".csv") return holds_frame_poses(path);
  if (!is_json(path)) return false;
  const auto text = read_file(path);
  return text && text->find("relief-scan") == std::string::npos &&
         !looks_like_nerf_transforms(*text);
}

Result<std::vector<RigidMotion>> read_poses_of_views(const fs::path& path,
                                                     const std::vector<std::string>& views,
                                                     std::vector<std::string>& notes) {
  std::vector<RgbdFrame> frames;
  for (const std::string& view : views) frames.emplace_back().name = view;
  const auto poses = is_json(path) && lists_views(path) ? poses_in_list(path, frames)
                                                        : read_frame_poses(path, frames, notes);
  if (!poses) return poses.error();
  std::vector<RigidMotion> all;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!(*poses)[i]) return bad_input(path, "has no pose for view " + views[i]);
    all.push_back((*poses)[i]->world_from_view);
  }
  return all;
}

}  // namespace relief
