#pragma once

#include <filesystem>
#include <optional>

#include "relief/scan/camera.h"
#include "relief/scan/result.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// What the files of an RGB-D camera may not tell.
struct RgbdOptions {
  std::optional<PinholeIntrinsics> intrinsics;  ///< Goes before a calibration file.
  std::optional<double> depth_scale;            ///< See metres_per_step().
};

/// Whether a folder holds depth maps in one of the layouts that read_rgbd_folder() knows.
bool is_rgbd_folder(const std::filesystem::path& folder);

/// Reads a folder of an RGB-D camera as a project in metres. Layouts:
/// - TUM: `depth.txt`, or a file of associations; `rgb.txt`; a trajectory with times. Images and
///   poses belong to a depth map when they are at most 0.02 s from it.
/// - `frame-000000.depth.png` with `frame-000000.pose.txt` (world from view, four rows) and
///   `frame-000000.color.png`.
/// - `depth/000000.png` with `color`, `image` or `rgb` beside it, and a trajectory: .log or .json
///   of Open3D, or a text of `[time] tx ty tz qx qy qz qw`. Else poses in `pose/000000.txt`.
/// Images are colours where they have the size of the depth map. Intrinsics come from the options,
/// the calibration file or the trajectory, the depth scale from the options, the calibration file
/// or, with `depth.txt` and `rgb.txt`, TUM's definition (5000). kBadInput when they are missing,
/// with the remedy, and for damaged files, with the place. Depth maps without a pose become views
/// without one, and the notes count them.
Result<ProjectSpec> read_rgbd_folder(const std::filesystem::path& folder,
                                     const RgbdOptions& options = {});

}  // namespace relief
