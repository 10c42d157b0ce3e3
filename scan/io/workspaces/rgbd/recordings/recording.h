#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string_view>

#include "relief/scan/camera.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"

namespace relief {

/// What a recording tells of one of its frames.
struct RecordedFrame {
  std::optional<RigidMotion> world_from_view;   ///< [m]
  std::optional<PinholeIntrinsics> intrinsics;  ///< Of the depth map.
  std::optional<double> depth_step;             ///< Length of a step of the depth map [m].
};

/// What a program that records RGB-D frames, or a dataset, wrote beside the images.
struct Recording {
  Calibration calibration;  ///< Of all depth maps, as far as they have one.
  /// By the number of a frame, which is the name of its files: 7 for `000007.png`.
  std::map<int, RecordedFrame> frames;
  /// The folder of images, named as the depth maps, that are 0 where these are not to be believed.
  std::optional<std::filesystem::path> masks;
};

/// The number of a frame by its name, from 0 to a thousand million; nothing for other names.
std::optional<int> frame_number(std::string_view name);

/// The recording of a folder by its files: read_record3d_metadata(), read_stray_scanner() or
/// read_bop_scene(). Nothing where there is none of them; kBadInput names what is wrong in one.
Result<std::optional<Recording>> find_recording(const std::filesystem::path& folder);

}  // namespace relief
