#include "scan/io/workspaces/rgbd/rgbd_layouts.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/files/io_error.h"
#include "scan/io/workspaces/rgbd/poses/named_poses.h"
#include "scan/io/workspaces/rgbd/replica_layout.h"
#include "scan/io/workspaces/rgbd/tum_layout.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// `frame-000000` and `.` of `frame-000000.depth.png`.
struct FrameName {
  std::string name, separator;

  fs::path beside(const fs::path& depth, std::string_view part) const {
    return depth.parent_path() / (name + separator + std::string(part));
  }
};

// Of a depth map that names a frame. Names with other separators than a point are common, so one of
// these tells the layout only with a pose of the same name: `000000_pose.txt`, `000000_depth.png`.
std::optional<FrameName> frame_of_depth(const fs::path& path) {
  constexpr std::string_view kDepth = "depth";
  const std::string stem = path.stem().string();
  if (!has_depth_image_ending(path) || !stem.ends_with(kDepth)) return std::nullopt;
  const std::string begin = stem.substr(0, stem.size() - kDepth.size());
  if (begin.size() < 2) return std::nullopt;
  const FrameName frame{begin.substr(0, begin.size() - 1), begin.substr(begin.size() - 1)};
  const bool separated = frame.separator == "_" || frame.separator == "-";
  if (frame.separator == "." || (separated && is_file(frame.beside(path, "pose.txt"))))
    return frame;
  return std::nullopt;
}

bool has_frames(const fs::path& folder) {
  const auto files = files_in(folder);
  return std::any_of(files.begin(), files.end(),
                     [](const fs::path& file) { return frame_of_depth(file).has_value(); });
}

std::vector<fs::path> depth_images(const fs::path& folder) {
  auto files = files_in(folder);
  std::erase_if(files, [](const fs::path& file) { return !has_depth_image_ending(file); });
  return files;
}

// PNGs of colours or 8 bits among depth maps are pictures of these. Returns how many are left out.
std::size_t leave_out_pictures(std::vector<fs::path>& files) {
  const auto is_picture = [](const fs::path& file) {
    return lower_ending(file) == ".png" && !is_grey_16_bit_png(file);
  };
  std::vector<fs::path> depths;
  std::ranges::remove_copy_if(files, std::back_inserter(depths), is_picture);
  if (depths.empty()) return 0;  // Nothing tells that they are pictures.
  std::swap(files, depths);
  return depths.size() - files.size();
}

Result<std::optional<RigidMotion>> pose_in_npy(std::string_view content, const fs::path& path) {
  const auto poses = parse_npy_poses(content, path);
  if (!poses) return poses.error();
  if (poses->world_from_view.size() != 1)
    return bad_input(path, "expected one matrix of 4x4 or 3x4 floats");
  return poses->world_from_view.front();
}

// A pose in a file of its own. Trackers that lost the camera write numbers that are none.
Result<std::optional<RigidMotion>> pose_in_file(const fs::path& path) {
  const auto text = read_file(path);
  if (!text) return text.error();
  if (lower_ending(path) == ".npy") return pose_in_npy(*text, path);
  for (const char* lost : {"inf", "INF", "nan", "NaN", "#QNAN", "#IND"})
    if (text->find(lost) != std::string::npos) return std::optional<RigidMotion>();
  NumberedLines lines(*text, path);
  auto motion = parse_motion_rows(lines, "the pose");
  if (!motion) return motion.error();
  return std::optional(*motion);
}

Result<void> take_pose_file(const fs::path& path, RgbdFrames& found, RgbdFrame& frame) {
  if (!is_file(path)) return {};
  auto pose = pose_in_file(path);
  if (!pose) return pose.error();
  frame.pose = *pose;
  found.has_poses = true;
  return {};
}

// The colour images of named frames, by their names: `frame-000000.color.png`, `000000_rgb.jpg`.
std::map<std::string, fs::path> named_colours(const std::vector<fs::path>& files) {
  std::map<std::string, fs::path> colours;
  for (const fs::path& file : files) {
    const std::string stem = file.stem().string();
    const std::size_t end = stem.find_last_of("._-");
    if (!has_photograph_ending(file) || end == std::string::npos) continue;
    const std::string part = lower_case(stem.substr(end + 1));
    if (part == "color" || part == "rgb") colours.emplace(stem.substr(0, end), file);
  }
  return colours;
}

Result<RgbdFrames> named_frames(const fs::path& folder) {
  const auto files = files_in(folder);
  const auto colours = named_colours(files);
  RgbdFrames found;
  for (const fs::path& file : files) {
    const auto named = frame_of_depth(file);
    if (!named) continue;
    RgbdFrame frame;
    frame.name = named->name;
    frame.depth = file;
    if (const auto colour = colours.find(frame.name); colour != colours.end())
      frame.colour = colour->second;
    const fs::path pose = named->beside(file, "pose.txt");
    const bool posed = is_file(pose);
    const fs::path extrinsic = named->beside(file, "extrinsic.txt");
    if (auto taken = take_pose_file(posed ? pose : extrinsic, found, frame); !taken)
      return taken.error();
    if (!posed && frame.pose) frame.pose = frame.pose->inverse();  // It is view from world.
    found.frames.push_back(std::move(frame));
  }
  return found;
}

// Whether a file of the folder itself holds the poses of a camera.
bool has_trajectory(const fs::path& folder) {
  return std::ranges::any_of(files_in(folder), [](const fs::path& file) {
    if (lower_ending(file) != ".txt") return false;
    const RgbdText kind = kind_of_rgbd_text(first_bytes(file));
    return kind == RgbdText::kTumPoses || kind == RgbdText::kPlainPoses ||
           kind == RgbdText::kLogPoses || kind == RgbdText::kMatrixPoses;
  });
}

// Of the folder of depth maps: nothing behind `depth`, or, beside poses, `_left` of TartanAir.
std::optional<std::string> depth_folder_suffix(const fs::path& folder) {
  if (!depth_images(folder / "depth").empty()) return "";
  for (const char* suffix : {"_left", "_right"})
    if (!depth_images(folder / (std::string("depth") + suffix)).empty() && has_trajectory(folder))
      return suffix;
  return std::nullopt;
}

// The colour images of `frames`: those of the same name, or else, where there are as many, those in
// the same place of the order.
void pair_colours(const fs::path& folder, const std::string& suffix,
                  std::vector<RgbdFrame>& frames) {
  for (const char* kind : {"color", "colour", "image", "rgb"}) {
    const std::string name = kind + suffix;
    auto files = files_in(folder / name);
    std::erase_if(files, [](const fs::path& file) { return !has_photograph_ending(file); });
    if (files.empty()) continue;
    std::map<std::string, fs::path> by_name;
    for (const fs::path& file : files) by_name.emplace(file.stem().string(), file);
    bool any = false;
    for (RgbdFrame& frame : frames)
      if (const auto file = by_name.find(frame.name); file != by_name.end()) {
        frame.colour = file->second;
        any = true;
      }
    if (!any && files.size() == frames.size())
      for (std::size_t i = 0; i < files.size(); ++i) frames[i].colour = files[i];
    return;
  }
}

Result<RgbdFrames> folder_frames(const fs::path& folder) {
  RgbdFrames found;
  found.suffix = depth_folder_suffix(folder).value_or("");
  auto files = depth_images(folder / ("depth" + found.suffix));
  if (const std::size_t pictures = leave_out_pictures(files); pictures > 0)
    found.notes.push_back(std::to_string(pictures) +
                          " images beside the depth maps are left out: pictures, of colours or of "
                          "8 bits a pixel");
  for (const fs::path& file : files) {
    RgbdFrame frame;
    frame.name = file.stem().string();
    frame.depth = file;
    for (const char* poses : {"pose", "poses"})
      for (const char* ending : {".npy", ".txt"})  // The text counts where both are there.
        if (auto taken = take_pose_file(folder / poses / (frame.name + ending), found, frame);
            !taken)
          return taken.error();
    found.frames.push_back(std::move(frame));
  }
  pair_colours(folder, found.suffix, found.frames);
  return found;
}

}  // namespace

std::string first_bytes(const fs::path& path) {
  constexpr std::size_t kFirstBytes = 1 << 14;  // Bounds the time.
  std::ifstream file(path, std::ios::binary);
  std::string text(kFirstBytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

RgbdLayout rgbd_layout(const fs::path& folder) {
  if (has_tum_list(folder)) return RgbdLayout::kTum;
  if (has_frames(folder)) return RgbdLayout::kFrames;
  if (tum_association_file(folder)) return RgbdLayout::kTum;
  if (has_replica_depths(folder)) return RgbdLayout::kReplica;
  return depth_folder_suffix(folder) ? RgbdLayout::kFolders : RgbdLayout::kNone;
}

Result<RgbdFrames> list_rgbd_frames(const fs::path& folder) {
  switch (rgbd_layout(folder)) {
    case RgbdLayout::kTum:
      return tum_frames(folder);
    case RgbdLayout::kFrames:
      return named_frames(folder);
    case RgbdLayout::kFolders:
      return folder_frames(folder);
    case RgbdLayout::kReplica:
      return replica_frames(folder);
    case RgbdLayout::kNone:
      break;
  }
  return bad_input(
      folder,
      "no depth maps in a layout that is known: depth.txt and rgb.txt, "
      "frame-000000.depth.png, a folder depth, or depth000000.png in a folder results");
}

}  // namespace relief
