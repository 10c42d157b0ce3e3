#include "scan/io/workspaces/rgbd/poses/named_pose_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/recordings/recording.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// A hundred thousand poses. What is larger holds something else, and takes long to read.
constexpr std::uintmax_t kMaxBytes = 1 << 26;

Result<NamedPoses> poses_in(const fs::path& file) {
  const std::string ending = lower_ending(file);
  const auto parse = ending == ".json"  ? parse_json_poses
                     : ending == ".npy" ? parse_npy_poses
                     : ending == ".csv" || (ending == ".txt" && !has_calibration_name(file))
                         ? parse_pose_table
                         : nullptr;
  std::error_code code;
  if (!parse || fs::file_size(file, code) > kMaxBytes || code) return NamedPoses();
  const auto content = read_file(file);
  if (!content) return content.error();
  return parse(*content, file);
}

using Poses = std::vector<std::optional<RigidMotion>>;  // Of all frames.

// Poses by what stands in a file, and by its end without the ending of an image.
std::map<std::string, const RigidMotion*> poses_of_names(const NamedPoses& poses) {
  std::map<std::string, const RigidMotion*> of_name;
  for (const NamedPose& pose : poses) {
    of_name.emplace(pose.name, &pose.world_from_view);
    of_name.emplace(fs::path(pose.name).stem().string(), &pose.world_from_view);
  }
  return of_name;
}

// Poses by their numbers, where names are alike but for these: `cam2grp` is no frame.
std::map<int, const RigidMotion*> poses_of_numbers(const NamedPoses& poses) {
  std::map<int, const RigidMotion*> of_number;
  std::set<std::string> patterns;
  for (const NamedPose& pose : poses) {
    std::string stem = fs::path(pose.name).stem().string();
    const auto number = frame_number(stem);
    if (!number) return {};
    of_number.emplace(*number, &pose.world_from_view);
    std::erase_if(stem, [](unsigned char c) { return std::isdigit(c); });
    patterns.insert(std::move(stem));
  }
  if (of_number.size() < 2 || patterns.size() > 1) return {};
  return of_number;
}

// By the names of frames, or else by their numbers; nothing where those are not of most frames, or
// of most poses.
std::optional<Poses> by_name(const NamedPoses& poses, const std::vector<RgbdFrame>& frames) {
  const auto of_name = poses_of_names(poses);
  const auto of_number = poses_of_numbers(poses);
  Poses found(frames.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto number = frame_number(frames[i].name);
    if (const auto named = of_name.find(frames[i].name); named != of_name.end())
      found[i] = *named->second;
    else if (const auto file = of_name.find(frames[i].depth.stem().string()); file != of_name.end())
      found[i] = *file->second;
    else if (const auto same = number ? of_number.find(*number) : of_number.end();
             same != of_number.end())
      found[i] = *same->second;
    count += found[i].has_value();
  }
  if (2 * count <= std::min(poses.size(), frames.size())) return std::nullopt;
  return found;
}

Poses in_order(const NamedPoses& poses) {
  Poses found;
  for (const NamedPose& pose : poses) found.emplace_back(pose.world_from_view);
  return found;
}

}  // namespace

Result<std::optional<NamedPoseFile>> find_named_poses(const fs::path& folder,
                                                      const std::vector<RgbdFrame>& frames) {
  for (const fs::path& file : files_in(folder)) {
    const auto poses = poses_in(file);
    if (!poses) return poses.error();
    if (poses->empty()) continue;
    if (auto named = by_name(*poses, frames))
      return std::optional(NamedPoseFile{file, std::move(*named)});
    if (poses->size() == frames.size()) return std::optional(NamedPoseFile{file, in_order(*poses)});
  }
  return std::optional<NamedPoseFile>();
}

std::vector<fs::path> files_named_as_poses(const fs::path& folder) {
  constexpr std::array<std::string_view, 6> kWords = {"pose",      "traj",     "groundtruth",
                                                      "extrinsic", "odometry", "transform"};
  std::vector<fs::path> named;
  for (const fs::path& file : files_in(folder)) {
    const std::string stem = lower_case(file.stem().string());
    if (std::ranges::any_of(
            kWords, [&](std::string_view word) { return stem.find(word) != std::string::npos; }))
      named.push_back(file);
  }
  return named;
}

}  // namespace relief
