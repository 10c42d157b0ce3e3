#include "scan/io/workspaces/rgbd/poses/trajectories.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>

#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// The number at the end of a word that begins with something else: `<qw>0.5` holds 0.5.
std::string_view number_behind_text(std::string_view word) {
  double number = 0.0;
  for (std::size_t i = 1; i < word.size(); ++i) {
    const char c = word[i];
    const bool starts = (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.';
    if (starts && parse_number(word.substr(i), number)) return word.substr(i);
  }
  return {};
}

// The pose on the line of a header: seven numbers behind a word that ends with one.
std::optional<std::array<double, 8>> pose_behind_header(std::string_view line) {
  const auto words = words_of(line);
  if (words.size() < 9) return std::nullopt;
  std::array<double, 8> pose;
  const std::size_t first = words.size() - 8;
  const std::string_view time = number_behind_text(words[first]);
  if (!parse_number(time, pose[0])) return std::nullopt;
  for (std::size_t i = 1; i < 8; ++i)
    if (!parse_number(words[first + i], pose[i])) return std::nullopt;
  return pose;
}

// `# timestamp filename1.5 depth/1.5.png`: an entry on the line of the header.
std::optional<TimedFile> entry_behind_header(std::string_view line) {
  const auto words = words_of(line);
  if (words.size() < 2) return std::nullopt;
  constexpr std::string_view kLastTitle = "filename";
  const std::string_view title = words[words.size() - 2];
  TimedFile entry;
  if (!title.starts_with(kLastTitle) || !parse_number(title.substr(kLastTitle.size()), entry.time))
    return std::nullopt;
  entry.file = std::string(words.back());
  return entry;
}

bool begins_with_number(std::string_view line) {
  double number = 0.0;
  return parse_number(next_word(line), number);
}

// Whether a line of so many words holds the numbers of a motion, and nothing else.
bool is_matrix(const std::vector<double>& numbers, std::size_t words) {
  return (numbers.size() == 12 || numbers.size() == 16) && numbers.size() == words;
}

bool parse_time(std::string_view word, double& time) {
  return parse_number(word, time) && std::isfinite(time);
}

Result<void> add_tum_pose(const double* pose, bool timed, const NumberedLines& lines,
                          Trajectory& trajectory) {
  const std::span<const double, 7> numbers(timed ? pose + 1 : pose, 7);
  TrajectoryPose added;
  added.is_lost = are_lost(numbers);
  if (timed) {
    if (!std::isfinite(pose[0])) return lines.error("the time is not a finite number");
    if (!trajectory.empty() && *trajectory.back().time > pose[0])
      return lines.error("the time is before that of the pose above; sort the lines by time");
    added.time = pose[0];
  }
  if (!added.is_lost) {
    const auto motion = motion_of_tum_numbers(numbers, lines);
    if (!motion) return motion.error();
    added.world_from_view = *motion;
  }
  trajectory.push_back(added);
  return {};
}

// A comment or header before the first pose. It may have a pose behind it.
Result<void> add_pose_of_header(std::string_view line, const NumberedLines& lines,
                                Trajectory& trajectory) {
  const auto pose = pose_behind_header(line);
  if (!pose) return {};
  return add_tum_pose(pose->data(), true, lines, trajectory);
}

}  // namespace

Result<std::vector<TimedFile>> parse_tum_list(std::string_view text, const fs::path& path) {
  NumberedLines lines(text, path);
  std::vector<TimedFile> entries;
  for (std::string_view line; lines.next_any(line);) {
    if (line.empty()) continue;
    const bool header = line.front() == '#' || (entries.empty() && !begins_with_number(line));
    if (header) {
      if (auto entry = entry_behind_header(line)) entries.push_back(std::move(*entry));
      continue;
    }
    const auto words = words_of(line, 2);
    TimedFile entry;
    if (words.size() != 2 || !parse_time(words[0], entry.time))
      return lines.error("expected 'time file'");
    entry.file = std::string(words[1]);
    entries.push_back(std::move(entry));
  }
  return entries;
}

Result<std::vector<FilePair>> parse_tum_associations(std::string_view text, const fs::path& path) {
  NumberedLines lines(text, path);
  std::vector<FilePair> pairs;
  for (std::string_view line; lines.next(line);) {
    if (pairs.empty() && !begins_with_number(line)) continue;
    const auto words = words_of(line);
    TimedFile first, second;
    if (words.size() < 4 || !parse_time(words[0], first.time) || !parse_time(words[2], second.time))
      return lines.error("expected 'time file time file'");
    first.file = std::string(words[1]);
    second.file = std::string(words[3]);
    const bool depth_first = first.file.find("depth") != std::string::npos &&
                             second.file.find("depth") == std::string::npos;
    if (!depth_first) std::swap(first, second);
    pairs.push_back({std::move(first), std::move(second)});
  }
  return pairs;
}

Result<Trajectory> parse_tum_trajectory(std::string_view text, const fs::path& path) {
  NumberedLines lines(text, path);
  Trajectory trajectory;
  bool first = true, timed = true;
  for (std::string_view line; lines.next_any(line);) {
    if (line.empty()) continue;
    if (line.front() == '#' || (first && !begins_with_number(line))) {
      if (!first) continue;
      if (auto added = add_pose_of_header(line, lines, trajectory); !added) return added.error();
      first = trajectory.empty();
      continue;
    }
    const std::vector<double> numbers = leading_numbers(line);
    const std::size_t count = numbers.size();
    if (first) timed = count != 7;
    if (count != (timed ? 8u : 7u) || words_of(line).size() != count)
      return lines.error(timed ? "expected 'time tx ty tz qx qy qz qw'"
                               : "expected 'tx ty tz qx qy qz qw', as on the lines above");
    if (auto added = add_tum_pose(numbers.data(), timed, lines, trajectory); !added)
      return added.error();
    first = false;
  }
  return trajectory;
}

// Whether the last four of the numbers of a pose can be a quaternion: of length 1, or nothing
// where a tracker was lost. Boxes of objects have as many numbers.
bool ends_in_rotation(const std::vector<double>& numbers) {
  const double squares =
      std::inner_product(numbers.end() - 4, numbers.end(), numbers.end() - 4, 0.0);
  constexpr double kRounded = 0.1;  // Quaternions of two digits.
  return !std::isfinite(squares) || squares == 0.0 || std::abs(squares - 1.0) < kRounded;
}

Result<Trajectory> parse_matrix_trajectory(std::string_view text, const fs::path& path) {
  NumberedLines lines(text, path);
  Trajectory trajectory;
  for (std::string_view line; lines.next(line);) {
    const std::vector<double> numbers = leading_numbers(line);
    if (!is_matrix(numbers, words_of(line).size()))
      return lines.error("expected the 12 or 16 numbers of a matrix");
    TrajectoryPose& pose = trajectory.emplace_back();
    pose.is_lost = are_lost(numbers);
    if (pose.is_lost) continue;
    auto motion = motion_of_numbers(numbers, "the matrix");
    if (!motion) return lines.error(motion.error().message);
    pose.world_from_view = *motion;
  }
  return trajectory;
}

Result<Trajectory> parse_log_trajectory(std::string_view text, const fs::path& path) {
  NumberedLines lines(text, path);
  Trajectory trajectory;
  for (std::string_view line; lines.next(line);) {
    double frame[3];
    if (!parse_row(line, 3, frame))
      return lines.error("expected three whole numbers before the rows of a pose");
    if (frame[0] != frame[1])
      return lines.error(
          "this is a pose of one frame relative to another; a trajectory has the same number "
          "twice, and poses in the world");
    const std::string what = "the matrix of pose " + std::to_string(trajectory.size());
    const auto numbers = parse_matrix_rows(lines, what);
    if (!numbers) return numbers.error();
    TrajectoryPose& pose = trajectory.emplace_back();
    pose.is_lost = are_lost(*numbers);
    if (pose.is_lost) continue;
    auto motion = motion_of_numbers(*numbers, what);
    if (!motion) return lines.error(motion.error().message);
    pose.world_from_view = *motion;
  }
  return trajectory;
}

RgbdText kind_of_rgbd_text(std::string_view text) {
  text = without_byte_order_mark(text);
  for (int line_count = 0; !text.empty() && line_count < 64; ++line_count) {
    const std::string_view line = trimmed(next_line(text));
    if (line.empty()) continue;
    if (pose_behind_header(line) && !begins_with_number(line)) return RgbdText::kTumPoses;
    if (entry_behind_header(line)) return RgbdText::kList;
    if (line.front() == '#' || !begins_with_number(line)) continue;
    const std::size_t words = words_of(line).size();
    const auto row = leading_numbers(line);
    const std::size_t numbers = row.size();
    if (is_matrix(row, words) && are_lost(row)) continue;
    if (is_matrix(row, words))
      return motion_of_numbers(row, "") ? RgbdText::kMatrixPoses : RgbdText::kUnknown;
    if (numbers == words && (words == 7 || words == 8)) {
      if (!ends_in_rotation(row)) return RgbdText::kUnknown;
      return words == 8 ? RgbdText::kTumPoses : RgbdText::kPlainPoses;
    }
    if (numbers == words && words == 3) {
      // A matrix of intrinsics has three numbers a line, too; the next line tells.
      const std::string_view next = trimmed(next_line(text));
      return leading_numbers(next).size() == 4 ? RgbdText::kLogPoses : RgbdText::kUnknown;
    }
    if (numbers == 1 && words == 2) return RgbdText::kList;
    double second_time = 0.0;
    if (numbers == 1 && words == 4 && parse_number(words_of(line)[2], second_time))
      return RgbdText::kAssociations;
    return RgbdText::kUnknown;
  }
  return RgbdText::kUnknown;
}

std::optional<Error> error_of_first_pose(std::string_view text, const fs::path& path) {
  constexpr std::size_t kLeastOfTum = 7, kLeastOfMatrix = 9;
  NumberedLines lines(text, path);
  for (std::string_view line; lines.next(line);) {
    if (!begins_with_number(line)) continue;
    const std::size_t count = leading_numbers(line).size();
    if (count < kLeastOfTum || count != words_of(line).size()) return std::nullopt;
    const auto read = count < kLeastOfMatrix ? parse_tum_trajectory(text, path)
                                             : parse_matrix_trajectory(text, path);
    return read ? std::nullopt : std::optional(read.error());
  }
  return std::nullopt;
}

std::optional<RigidMotion> pose_at(const Trajectory& trajectory, double time, double tolerance) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), time,
                       [](const TrajectoryPose& pose, double t) { return *pose.time < t; });
  const auto near = [&](const TrajectoryPose& pose) {
    return std::abs(*pose.time - time) <= tolerance;
  };
  const bool has_after = after != trajectory.end() && near(*after);
  const bool has_before = after != trajectory.begin() && near(*std::prev(after));
  if (!has_after && !has_before) return std::nullopt;
  if ((has_after && after->is_lost) || (has_before && std::prev(after)->is_lost))
    return std::nullopt;
  if (!has_before) return after->world_from_view;
  const TrajectoryPose& before = *std::prev(after);
  if (!has_after) return before.world_from_view;
  const double gap = *after->time - *before.time;
  const double fraction = gap > 0.0 ? (time - *before.time) / gap : 0.0;
  RigidMotion pose = RigidMotion::Identity();
  pose.linear() = Eigen::Quaterniond(before.world_from_view.linear())
                      .slerp(fraction, Eigen::Quaterniond(after->world_from_view.linear()))
                      .toRotationMatrix();
  pose.translation() = (1.0 - fraction) * before.world_from_view.translation() +
                       fraction * after->world_from_view.translation();
  return pose;
}

}  // namespace relief
