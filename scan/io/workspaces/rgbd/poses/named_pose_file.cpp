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
#include "scan/io/files/io_error.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/recordings/recording.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// A hundred thousand poses. What is larger holds something else, and takes long to read.
constexpr std::uintmax_t kMaxBytes = 1 << 26;

bool is_named_as_poses(const fs::path& file) {
  constexpr std::array<std::string_view, 6> kWords = {"pose",      "traj",     "groundtruth",
                                                      "extrinsic", "odometry", "transform"};
  const std::string stem = lower_case(file.stem().string());
  return std::ranges::any_of(
      kWords, [&](std::string_view word) { return stem.find(word) != std::string::npos; });
}

Result<PoseList> poses_in(const fs::path& file) {
  const std::string ending = lower_ending(file);
  const auto parse = ending == ".json"  ? parse_json_poses
                     : ending == ".npy" ? parse_npy_poses
                     : ending == ".csv" || (ending == ".txt" && !has_calibration_name(file))
                         ? parse_pose_table
                         : nullptr;
  std::error_code code;
  if (!parse || fs::file_size(file, code) > kMaxBytes || code) return PoseList();
  const auto content = read_file(file);
  if (!content) return content.error();
  return parse(*content, file);
}

std::string stem_of(const std::string& name) { return fs::path(name).stem().string(); }

// The numbers of names that are alike but for these: `cam2grp` is no frame.
std::vector<int> numbers_of(const std::vector<std::string>& names) {
  std::vector<int> numbers;
  std::set<std::string> patterns;
  for (const std::string& name : names) {
    std::string stem = stem_of(name);
    const auto number = frame_number(stem);
    if (!number) return {};
    numbers.push_back(*number);
    std::erase_if(stem, [](unsigned char c) { return std::isdigit(c) != 0; });
    patterns.insert(std::move(stem));
  }
  if (std::set(numbers.begin(), numbers.end()).size() < 2 || patterns.size() > 1) return {};
  return numbers;
}

// From the numbers of frames to those of as many poses: the constant between them; 0 for others.
int offset_between(std::vector<int> frames, std::vector<int> poses) {
  if (frames.size() != poses.size() || frames.empty()) return 0;
  std::ranges::sort(frames);
  std::ranges::sort(poses);
  const int offset = poses.front() - frames.front();
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (poses[i] - frames[i] != offset) return 0;
  return offset;
}

// Poses of the frames that one field of a file tells.
struct MatchedPoses {
  PosesOfFrames of_frames;
  std::size_t count = 0;
  int offset = 0;  // Of the numbers.
};

MatchedPoses match_by_number(const PoseList& poses, const std::vector<std::string>& names,
                             const std::vector<RgbdFrame>& frames) {
  MatchedPoses matched{PosesOfFrames(frames.size()), 0, 0};
  std::vector<std::string> frame_names;
  for (const RgbdFrame& frame : frames) frame_names.push_back(frame.name);
  const auto of_frames = numbers_of(frame_names), of_poses = numbers_of(names);
  if (of_frames.empty() || of_poses.empty()) return matched;
  matched.offset = offset_between(of_frames, of_poses);
  std::map<int, std::size_t> by_number;
  for (std::size_t k = 0; k < of_poses.size(); ++k) by_number.emplace(of_poses[k], k);
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (const auto found = by_number.find(of_frames[i] + matched.offset);
        found != by_number.end()) {
      matched.of_frames[i] = poses.world_from_view[found->second];
      ++matched.count;
    }
  return matched;
}

MatchedPoses match_by_name(const PoseList& poses, const std::vector<std::string>& names,
                           const std::vector<RgbdFrame>& frames) {
  std::map<std::string, std::size_t> by_name;
  for (std::size_t k = 0; k < names.size(); ++k) {
    by_name.emplace(names[k], k);
    by_name.emplace(stem_of(names[k]), k);
  }
  MatchedPoses matched{PosesOfFrames(frames.size()), 0, 0};
  for (std::size_t i = 0; i < frames.size(); ++i)
    for (const std::string& name : {frames[i].name, frames[i].depth.stem().string()})
      if (const auto found = by_name.find(name); found != by_name.end()) {
        matched.of_frames[i] = poses.world_from_view[found->second];
        ++matched.count;
        break;
      }
  return matched;
}

// The names or numbers that are of most frames; none unless of most of the poses or of the frames.
std::optional<MatchedPoses> match_frames(const PoseList& poses,
                                         const std::vector<RgbdFrame>& frames) {
  std::optional<MatchedPoses> best;
  const std::size_t count = poses.world_from_view.size();
  for (const auto& [field, names] : poses.names) {
    if (names.size() != count) continue;
    for (const auto match : {match_by_name, match_by_number}) {
      auto matched = match(poses, names, frames);
      if (2 * matched.count <= std::min(count, frames.size())) continue;
      if (!best || matched.count > best->count) best = std::move(matched);
    }
  }
  return best;
}

// A file with poses of the frames. Those that are matched by a name, and named as poses, rank
// highest.
struct Candidate {
  NamedPoseFile file;
  int rank = 0;
};

// `is_named`: as poses, so that they may be in the order of the frames.
std::optional<Candidate> candidate_of(const fs::path& file, bool is_named, const PoseList& poses,
                                      const std::vector<RgbdFrame>& frames) {
  const auto lost =
      std::ranges::count_if(poses.world_from_view, [](const auto& pose) { return !pose; });
  std::vector<std::string> notes;
  if (auto note = note_on_lost_poses(lost, poses.world_from_view.size()))
    notes.push_back(std::move(*note));
  if (auto matched = match_frames(poses, frames)) {
    if (matched->offset != 0)
      notes.push_back("the numbers of the poses are those of the depth maps plus " +
                      std::to_string(matched->offset));
    return Candidate{{file, std::move(matched->of_frames), std::move(notes)}, is_named ? 2 : 1};
  }
  if (!is_named || !poses.is_ordered || poses.world_from_view.size() != frames.size())
    return std::nullopt;
  return Candidate{{file, poses.world_from_view, std::move(notes)}, 0};
}

bool are_same(const PosesOfFrames& a, const PosesOfFrames& b) {
  return std::ranges::equal(a, b, [](const auto& p, const auto& q) {
    return p.has_value() == q.has_value() && (!p || p->isApprox(*q));
  });
}

}  // namespace

Result<std::optional<NamedPoseFile>> find_named_poses(const fs::path& folder,
                                                      const std::vector<RgbdFrame>& frames) {
  std::optional<Candidate> best;
  std::optional<fs::path> rival;
  for (const fs::path& file : files_in(folder)) {
    const auto poses = poses_in(file);
    if (!poses && is_named_as_poses(file)) return poses.error();
    if (!poses || poses->empty()) continue;
    auto candidate = candidate_of(file, is_named_as_poses(file), *poses, frames);
    if (!candidate || (best && candidate->rank < best->rank)) continue;
    if (best && candidate->rank == best->rank) {
      if (!are_same(candidate->file.world_from_view, best->file.world_from_view)) rival = file;
      continue;
    }
    best = std::move(candidate);
    rival.reset();
  }
  if (rival)
    return bad_input(*rival, "has poses of the depth maps, and so has " +
                                 best->file.path.filename().string() +
                                 " beside it; keep one of them");
  return best ? std::optional(std::move(best->file)) : std::nullopt;
}

bool holds_named_poses(const fs::path& file) {
  const auto poses = poses_in(file);
  return !poses || !poses->empty() || is_named_as_poses(file);
}

Result<NamedPoseFile> read_named_poses(const fs::path& file, const std::vector<RgbdFrame>& frames) {
  const auto poses = poses_in(file);
  if (!poses) return poses.error();
  if (poses->empty()) return bad_input(file, kNoFormOfPoses);
  auto candidate = candidate_of(file, /*is_named=*/true, *poses, frames);
  if (candidate) return std::move(candidate->file);
  const std::string counts = std::to_string(poses->world_from_view.size()) + " poses for " +
                             std::to_string(frames.size()) + " views";
  return bad_input(file, counts + ", and neither names nor numbers tell which are whose");
}

std::optional<std::string> note_on_lost_poses(std::ptrdiff_t lost, std::size_t poses) {
  if (lost == 0) return std::nullopt;
  return std::to_string(lost) + " of its " + std::to_string(poses) +
         " poses are no motion, as where tracking is lost: they are not taken";
}

std::vector<fs::path> files_named_as_poses(const fs::path& folder) {
  constexpr std::array<std::string_view, 9> kEndings = {".txt", ".csv", ".json", ".npy", ".npz",
                                                        ".mat", ".log", ".yaml", ".yml"};
  auto files = files_in(folder);
  std::erase_if(files, [&](const fs::path& file) {
    return !is_named_as_poses(file) ||
           std::ranges::find(kEndings, lower_ending(file)) == kEndings.end();
  });
  return files;
}

}  // namespace relief
