#include "scan/io/workspaces/rgbd/poses/frame_poses.h"

#include <algorithm>
#include <cstddef>
#include <set>
#include <string_view>
#include <utility>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/files/io_error.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/open3d_json.h"
#include "scan/io/workspaces/rgbd/poses/named_pose_file.h"
#include "scan/io/workspaces/rgbd/poses/poses_by_time.h"
#include "scan/io/workspaces/rgbd/recordings/recording.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

FramePoses frame_poses(const PosesOfFrames& world_from_view) {
  FramePoses poses(world_from_view.size());
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (world_from_view[i]) poses[i].emplace().world_from_view = *world_from_view[i];
  return poses;
}

// By the order of the frames.
std::optional<TrajectoryPose> unless_lost(const TrajectoryPose& pose) {
  return pose.is_lost ? std::nullopt : std::optional(pose);
}

// The parser for a file, if the file is a trajectory.
using TrajectoryParser = Result<Trajectory> (*)(std::string_view, const fs::path&);

TrajectoryParser trajectory_parser(const fs::path& file) {
  const std::string ending = lower_ending(file);
  const bool is_json = ending == ".json";
  if (!is_json && ending != ".txt" && ending != ".log" && ending != ".tum" &&
      ending != ".freiburg" && ending != ".traj")
    return nullptr;
  const std::string head = first_bytes(file);
  if (is_json) return looks_like_open3d_trajectory(head) ? parse_open3d_trajectory : nullptr;
  if (has_calibration_name(file)) return nullptr;
  switch (kind_of_rgbd_text(head)) {
    case RgbdText::kTumPoses:
    case RgbdText::kPlainPoses:
      return parse_tum_trajectory;
    case RgbdText::kLogPoses:
      return parse_log_trajectory;
    case RgbdText::kMatrixPoses:
      return parse_matrix_trajectory;
    default:
      return nullptr;
  }
}

struct TrajectoryFile {
  fs::path path;
  TrajectoryParser parse = nullptr;
};

// Which of several trajectories is taken, the larger the sooner: Open3D writes `odometry.log`,
// which drifts, beside the `trajectory.log` of the whole.
int precedence(const fs::path& file, const std::string& suffix) {
  if (!suffix.empty() && file.stem().string().ends_with(suffix)) return 3;
  if (file.stem() == "groundtruth") return 2;
  return file.stem() == "trajectory" ? 1 : 0;
}

// The trajectory of a folder. Two of the same precedence are an error.
Result<std::optional<TrajectoryFile>> find_trajectory(const fs::path& folder,
                                                      const std::string& suffix) {
  std::optional<TrajectoryFile> found;
  std::optional<fs::path> rival;
  for (const fs::path& file : files_in(folder)) {
    const TrajectoryParser parse = trajectory_parser(file);
    if (!parse) continue;
    const int order = found ? precedence(file, suffix) - precedence(found->path, suffix) : 1;
    if (order == 0) rival = file;
    if (order <= 0) continue;
    found = TrajectoryFile{file, parse};
    rival.reset();
  }
  if (rival)
    return bad_input(*rival, "is a trajectory, and so is " + found->path.filename().string() +
                                 " beside it; keep one of them, or call it groundtruth.txt");
  return found;
}

// Of a trajectory that has more poses than there are frames: those of the numbers in the names of
// frames, which count from 0, or from 1 where the last one is the number of poses.
std::optional<FramePoses> poses_by_number(const Trajectory& trajectory,
                                          const std::vector<RgbdFrame>& frames) {
  std::vector<std::size_t> numbers;
  for (const RgbdFrame& frame : frames) {
    const auto number = frame_number(frame.name);
    if (!number) return std::nullopt;
    numbers.push_back(static_cast<std::size_t>(*number));
  }
  const auto [least, most] = std::minmax_element(numbers.begin(), numbers.end());
  if (numbers.empty() || std::set(numbers.begin(), numbers.end()).size() < numbers.size())
    return std::nullopt;
  const std::size_t first = *least > 0 && *most == trajectory.size() ? 1 : 0;
  if (*most - first >= trajectory.size()) return std::nullopt;
  FramePoses poses;
  for (const std::size_t number : numbers) poses.push_back(unless_lost(trajectory[number - first]));
  return poses;
}

Result<FramePoses> assign_poses(const Trajectory& trajectory, const fs::path& path,
                                const std::vector<RgbdFrame>& frames,
                                std::vector<std::string>& notes) {
  const bool timed = !trajectory.empty() && trajectory.front().time.has_value();
  if (timed)
    if (const auto poses = poses_by_time(trajectory, frames, notes)) return frame_poses(*poses);
  if (trajectory.size() == frames.size()) {
    FramePoses poses;
    for (const TrajectoryPose& pose : trajectory) poses.push_back(unless_lost(pose));
    return poses;
  }
  if (!timed)
    if (auto poses = poses_by_number(trajectory, frames)) {
      notes.emplace_back("the trajectory has " + std::to_string(trajectory.size()) +
                         " poses: each frame takes that of its number");
      return std::move(*poses);
    }
  const std::string counts =
      std::to_string(trajectory.size()) + " poses for " + std::to_string(frames.size()) + " views";
  return bad_input(path, timed ? counts +
                                     ", and none within 0.02 s of a depth map; give the "
                                     "trajectory of this sequence"
                               : counts + "; a trajectory without times needs one pose for each");
}

Result<FramePoses> poses_of_trajectory(const TrajectoryFile& file,
                                       const std::vector<RgbdFrame>& frames,
                                       std::vector<std::string>& notes) {
  const auto text = read_file(file.path);
  if (!text) return text.error();
  const auto trajectory = file.parse(*text, file.path);
  if (!trajectory) return trajectory.error();
  notes.push_back("poses from " + file.path.string());
  const auto lost = std::ranges::count_if(*trajectory, &TrajectoryPose::is_lost);
  if (auto note = note_on_lost_poses(lost, trajectory->size())) notes.push_back(std::move(*note));
  return assign_poses(*trajectory, file.path, frames, notes);
}

FramePoses poses_of_named(const NamedPoseFile& named, std::vector<std::string>& notes) {
  notes.push_back("poses from " + named.path.string());
  notes.insert(notes.end(), named.notes.begin(), named.notes.end());
  return frame_poses(named.world_from_view);
}

// Why a file is no trajectory, where its first pose keeps it from being one.
std::optional<Error> error_in(const fs::path& file) {
  const std::string ending = lower_ending(file);
  if (ending == ".json" || ending == ".npy") return std::nullopt;
  return error_of_first_pose(first_bytes(file), file);
}

std::string note_on_unread(const fs::path& file) {
  if (const auto error = error_in(file)) return error->message + "; the file is not read";
  return file.string() + ": is not read, as it " + kNoFormOfPoses;
}

// Poses of a file that names the frames. A note tells of files that should have poses and do not.
Result<FramePoses> poses_by_name(const fs::path& folder, const std::vector<RgbdFrame>& frames,
                                 std::vector<std::string>& notes) {
  const auto named = find_named_poses(folder, frames);
  if (!named) return named.error();
  if (!*named) {
    for (const fs::path& file : files_named_as_poses(folder)) notes.push_back(note_on_unread(file));
    return FramePoses(frames.size());
  }
  return poses_of_named(**named, notes);
}

}  // namespace

Result<FramePoses> find_frame_poses(const fs::path& folder, const RgbdFrames& found,
                                    std::vector<std::string>& notes) {
  if (found.has_poses) {
    PosesOfFrames own;
    for (const RgbdFrame& frame : found.frames) own.push_back(frame.pose);
    return frame_poses(own);
  }
  const auto file = find_trajectory(folder, found.suffix);
  if (!file) return file.error();
  if (!*file) return poses_by_name(folder, found.frames, notes);
  return poses_of_trajectory(**file, found.frames, notes);
}

bool holds_frame_poses(const fs::path& file) {
  return trajectory_parser(file) || holds_named_poses(file);
}

Result<FramePoses> read_frame_poses(const fs::path& file, const std::vector<RgbdFrame>& frames,
                                    std::vector<std::string>& notes) {
  if (const TrajectoryParser parse = trajectory_parser(file))
    return poses_of_trajectory({file, parse}, frames, notes);
  const auto named = read_named_poses(file, frames);
  if (!named)
    if (auto error = error_in(file)) return std::move(*error);
  return named ? Result(poses_of_named(*named, notes)) : named.error();
}

}  // namespace relief
