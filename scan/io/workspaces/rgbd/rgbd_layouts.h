#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "scan/io/workspaces/rgbd/agreement/depth_scale.h"
#include "scan/io/workspaces/rgbd/poses/trajectories.h"

namespace relief {

/// How far apart in time two records of one moment are at most [s], as in TUM's own tools.
inline constexpr double kSameMoment = 0.02;

/// A depth map and what lies beside it.
struct RgbdFrame {
  std::string name;
  std::filesystem::path depth;
  std::optional<std::filesystem::path> colour;
  std::optional<double> time;       ///< [s], from a list of files.
  std::optional<RigidMotion> pose;  ///< From a file of its own, or a recording.
  /// Of the depth map, where a recording tells them: with the size it should have, and the length
  /// of its steps [m].
  std::optional<PinholeIntrinsics> intrinsics;
  std::optional<ImageSize> size;
  std::optional<double> depth_step;
  std::optional<std::filesystem::path> mask;  ///< 0: no sample.
};

struct RgbdFrames {
  std::vector<RgbdFrame> frames;
  bool has_poses = false;                   ///< Of single frames: no trajectory is looked for.
  std::optional<double> depth_scale;        ///< Where the layout defines it.
  double usual_depth_scale = kMillimetres;  ///< Of sets in this layout, where nobody says another.
  std::string suffix;  ///< `_left` of `depth_left`: images and poses with it are those of these.
  std::vector<std::string> notes;
};

enum class RgbdLayout { kNone, kTum, kFrames, kFolders, kReplica };

/// The layout of a folder; looks at names and first lines only.
RgbdLayout rgbd_layout(const std::filesystem::path& folder);

/// The depth maps of a folder in the order of their times or numbers, with what is beside them.
Result<RgbdFrames> list_rgbd_frames(const std::filesystem::path& folder);

/// The first 16 KiB of a file; empty where it cannot be read.
std::string first_bytes(const std::filesystem::path& path);

}  // namespace relief
