#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "relief/scan/result.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"

namespace relief {

/// The calibration in a JSON object: `fx`, `fy`, `cx`, `cy` (or `ppx`, `ppy`), or a matrix of three
/// rows called `K`, `camera_matrix` or `intrinsics`; `width` and `height`; `depth_scale`. They may
/// lie in an object `depth`, `camera` or `intrinsics`. Nothing for other documents; kBadInput for a
/// focal length of 0.
Result<std::optional<Calibration>> parse_camera_json(std::string_view text,
                                                     const std::filesystem::path& path);

/// The calibration in the settings of ORB-SLAM (`Camera.fx: 535.4`, `DepthMapFactor: 5000`), or in
/// the `camera_matrix` or `K` of ROS and OpenCV. Nothing for other texts; kBadInput for a focal
/// length of 0 and for some of the four numbers alone. Distortion is not applied, and a note says
/// so.
Result<std::optional<Calibration>> parse_camera_yaml(std::string_view text,
                                                     const std::filesystem::path& path);

/// The intrinsics in a NumPy array of 3x3 floats; nothing for other arrays.
Result<std::optional<Calibration>> parse_camera_npy(std::string_view content,
                                                    const std::filesystem::path& path);

}  // namespace relief
