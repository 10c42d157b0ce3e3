#include "scan/io/workspaces/rgbd/poses/poses_by_time.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "scan/io/files/text_lines.h"

namespace relief {

namespace {

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

// With times of the trajectory and of the frames in their units.
PosesOfFrames poses_in_units(Trajectory trajectory, const TimeUnit& unit,
                             const std::vector<RgbdFrame>& frames, const TimeUnit& frame_unit) {
  for (TrajectoryPose& pose : trajectory) *pose.time *= unit.seconds;
  PosesOfFrames poses;
  for (const RgbdFrame& frame : frames) {
    const auto time = frame_time(frame);
    poses.push_back(time ? pose_at(trajectory, frame_unit.seconds * *time, kSameMoment)
                         : std::nullopt);
  }
  return poses;
}

// The units in which times of the trajectory, or of the frames, can be meant. The other ones are
// seconds.
std::vector<TimeUnit> possible_units(const std::vector<double>& times, double shortest_step) {
  std::vector<TimeUnit> units;
  if (times.size() < 2) return units;
  const auto [first, last] = std::ranges::minmax_element(times);
  const double shortest = shortest_step * static_cast<double>(times.size() - 1);
  for (const TimeUnit& unit : kOtherUnits)
    if (unit.seconds * (*last - *first) >= shortest) units.push_back(unit);
  return units;
}

}  // namespace

std::optional<PosesOfFrames> poses_by_time(const Trajectory& trajectory,
                                           const std::vector<RgbdFrame>& frames,
                                           std::vector<std::string>& notes) {
  std::vector<double> of_poses, of_frames;
  for (const TrajectoryPose& pose : trajectory) of_poses.push_back(*pose.time);
  for (const RgbdFrame& frame : frames)
    if (const auto time = frame_time(frame)) of_frames.push_back(*time);
  PosesOfFrames best;
  std::ptrdiff_t most = 0;
  std::string note;
  const auto compare = [&](const TimeUnit& unit, const TimeUnit& frame_unit, std::ptrdiff_t least,
                           const std::string& then) {
    auto poses = poses_in_units(trajectory, unit, frames, frame_unit);
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

}  // namespace relief
