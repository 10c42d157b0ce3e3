#include "scan/io/workspaces/rgbd/poses/frame_poses.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <set>
#include <string_view>
#include <utility>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/files/text_lines.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/open3d_json.h"
#include "scan/io/workspaces/rgbd/poses/named_pose_file.h"
#include "scan/io/workspaces/rgbd/recordings/recording.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

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

// The time of a frame: from a list, or the number that is its name.
std::optional<double> frame_time(const RgbdFrame& frame) {
  double time = 0.0;
  if (frame.time) return frame.time;
  return parse_number(frame.name, time) ? std::optional(time) : std::nullopt;
}

struct TimeUnit {
  double seconds = 1.0;
  const char* name = "seconds";
};
// Those that recorders write, besides seconds.
constexpr std::array<TimeUnit, 3> kOtherUnits = {
    {{1e-3, "milliseconds"}, {1e-6, "microseconds"}, {1e-9, "nanoseconds"}}};

// Poses of an inertial sensor, and depth maps of a fast camera, follow each other no faster [s]: in
// a wrong unit all would be at one moment.
constexpr double kStepOfPoses = 1e-4, kStepOfFrames = 4e-3;

bool are_of_a_sequence(const std::vector<double>& times, double shortest_step) {
  if (times.size() < 2) return false;
  const auto [first, last] = std::ranges::minmax_element(times);
  return *last - *first >= shortest_step * static_cast<double>(times.size() - 1);
}

// Poses by time, with times of the trajectory and of the frames in their units.
FramePoses poses_by_time(Trajectory trajectory, const TimeUnit& unit,
                         const std::vector<RgbdFrame>& frames, const TimeUnit& frame_unit) {
  for (TrajectoryPose& pose : trajectory) *pose.time *= unit.seconds;
  FramePoses poses(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto time = frame_time(frames[i]);
    const auto motion =
        time ? pose_at(trajectory, frame_unit.seconds * *time, kSameMoment) : std::nullopt;
    if (!motion) continue;
    poses[i].emplace();
    poses[i]->world_from_view = *motion;
  }
  return poses;
}

// The units in which times of the trajectory, or of the frames, can be meant. The other ones are
// seconds.
std::vector<TimeUnit> possible_units(const std::vector<double>& times, double shortest_step) {
  std::vector<TimeUnit> units;
  for (const TimeUnit& unit : kOtherUnits) {
    auto scaled = times;
    for (double& time : scaled) time *= unit.seconds;
    if (are_of_a_sequence(scaled, shortest_step)) units.push_back(unit);
  }
  return units;
}

// The same in seconds, or in other units in which more frames have poses, and more than half of
// all. Nothing where no frame has a pose.
std::optional<FramePoses> poses_by_time(const Trajectory& trajectory,
                                        const std::vector<RgbdFrame>& frames,
                                        std::vector<std::string>& notes) {
  std::vector<double> of_poses, of_frames;
  for (const TrajectoryPose& pose : trajectory) of_poses.push_back(*pose.time);
  for (const RgbdFrame& frame : frames)
    if (const auto time = frame_time(frame)) of_frames.push_back(*time);
  FramePoses best;
  std::ptrdiff_t most = 0;
  std::string note;
  const auto compare = [&](const TimeUnit& unit, const TimeUnit& frame_unit, std::ptrdiff_t least,
                           const std::string& then) {
    auto poses = poses_by_time(trajectory, unit, frames, frame_unit);
    const auto count = std::ranges::count_if(poses, [](const auto& pose) { return !!pose; });
    if (count <= std::max(most, least)) return;
    best = std::move(poses);
    most = count;
    note = then;
  };
  const TimeUnit seconds;
  const auto half = static_cast<std::ptrdiff_t>(frames.size() / 2);  // Some agree by chance.
  compare(seconds, seconds, 0, "");
  for (const TimeUnit& unit : possible_units(of_poses, kStepOfPoses))
    compare(unit, seconds, half, std::string("times of the trajectory are taken as ") + unit.name);
  for (const TimeUnit& unit : possible_units(of_frames, kStepOfFrames))
    compare(seconds, unit, half, std::string("times of the depth maps are taken as ") + unit.name);
  if (!note.empty()) notes.push_back(std::move(note));
  return most > 0 ? std::optional(std::move(best)) : std::nullopt;
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
  for (const std::size_t number : numbers) poses.emplace_back(trajectory[number - first]);
  return poses;
}

Result<FramePoses> assign_poses(const Trajectory& trajectory, const fs::path& path,
                                const std::vector<RgbdFrame>& frames,
                                std::vector<std::string>& notes) {
  const bool timed = !trajectory.empty() && trajectory.front().time.has_value();
  if (timed)
    if (auto poses = poses_by_time(trajectory, frames, notes)) return std::move(*poses);
  if (trajectory.size() == frames.size()) return FramePoses(trajectory.begin(), trajectory.end());
  if (!timed)
    if (auto poses = poses_by_number(trajectory, frames)) {
      notes.emplace_back("the trajectory has " + std::to_string(trajectory.size()) +
                         " poses: each frame takes that of its number");
      return std::move(*poses);
    }
  const std::string counts = std::to_string(trajectory.size()) + " poses for " +
                             std::to_string(frames.size()) + " depth maps";
  return bad_input(path, timed ? counts +
                                     ", and none within 0.02 s of a depth map; give the "
                                     "trajectory of this sequence"
                               : counts + "; a trajectory without times needs one pose for each");
}

// Poses of a file that names the frames. A note tells of files that should have poses and do not.
Result<FramePoses> poses_by_name(const fs::path& folder, const std::vector<RgbdFrame>& frames,
                                 std::vector<std::string>& notes) {
  FramePoses poses(frames.size());
  const auto named = find_named_poses(folder, frames);
  if (!named) return named.error();
  if (!*named) {
    for (const fs::path& file : files_named_as_poses(folder))
      notes.push_back(file.string() +
                      ": is not read, as it has no form of poses that is known; write 'tx ty tz qx "
                      "qy qz qw' or the 16 numbers of world_from_view a line, in the order of the "
                      "depth maps");
    return poses;
  }
  notes.push_back("poses from " + (*named)->path.string());
  if (!(*named)->note.empty()) notes.push_back((*named)->note);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!(*named)->world_from_view[i]) continue;
    poses[i].emplace();
    poses[i]->world_from_view = *(*named)->world_from_view[i];
  }
  return poses;
}

}  // namespace

Result<FramePoses> find_frame_poses(const fs::path& folder, const RgbdFrames& found,
                                    std::vector<std::string>& notes) {
  FramePoses poses(found.frames.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!found.frames[i].pose) continue;
    poses[i].emplace();
    poses[i]->world_from_view = *found.frames[i].pose;
  }
  if (found.has_poses) return poses;
  const auto file = find_trajectory(folder, found.suffix);
  if (!file) return file.error();
  if (!*file) return poses_by_name(folder, found.frames, notes);
  const auto text = read_file((*file)->path);
  if (!text) return text.error();
  const auto trajectory = (*file)->parse(*text, (*file)->path);
  if (!trajectory) return trajectory.error();
  notes.push_back("poses from " + (*file)->path.string());
  return assign_poses(*trajectory, (*file)->path, found.frames, notes);
}

}  // namespace relief
