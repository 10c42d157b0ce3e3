#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "relief/scan/camera.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"

namespace relief {

// Calibrations in files that may hold something else. Distortion is not applied, and a note says
// so where a file has some that is not 0.

/// The calibration in a JSON object: `fx`, `fy`, `cx`, `cy` (or `ppx`, `ppy`), or a matrix of three
/// rows called `K`, `camera_matrix`, `intrinsics` or `intrinsic`; `width` and `height`;
/// `depth_scale`. They may lie in an object `depth`, `camera` or `intrinsics`. Nothing for other
/// documents, and for a focal length of 0.
std::optional<Calibration> parse_camera_json(std::string_view text);

/// The calibration in the settings of ORB-SLAM (`Camera.fx: 535.4`, `DepthMapFactor: 5000`), or in
/// the `camera_matrix` or `K` of ROS and OpenCV. Nothing for other texts, for some of the four
/// numbers alone, and for a focal length of 0.
std::optional<Calibration> parse_camera_yaml(std::string_view text,
                                             const std::filesystem::path& path);

/// The intrinsics in a NumPy array of 3x3 floats; nothing for other arrays.
std::optional<Calibration> parse_camera_npy(std::string_view content,
                                            const std::filesystem::path& path);

/// The intrinsics of nine numbers by rows, `fx 0 cx 0 fy cy 0 0 1`; nothing for other matrices.
std::optional<PinholeIntrinsics> intrinsics_of_matrix(std::span<const double> numbers);

}  // namespace relief
