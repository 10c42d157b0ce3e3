#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/camera.h"
#include "relief/scan/result.h"
#include "scan/io/images/image_size.h"

namespace relief {

/// The length of a step of a depth map [m] by its scale: values per metre, as 1000, or below 1 the
/// metres of a value, as the 0.001 of RealSense. No sensor has steps of more than a metre.
inline double metres_per_step(double scale) { return scale < 1.0 ? scale : 1.0 / scale; }

/// Whether the numbers are finite and the focal lengths other than 0. A negative fy is one of
/// mirrored images.
bool can_be_intrinsics(const PinholeIntrinsics& intrinsics);

/// The size of images of so many pixels; nothing for numbers that are none.
std::optional<ImageSize> size_of_numbers(double width, double height);

/// What a calibration file of an RGB-D camera says.
struct Calibration {
  std::optional<PinholeIntrinsics> intrinsics;  ///< Integer coordinates are pixel centres.
  std::optional<ImageSize> size;                ///< Of the images they belong to.
  std::optional<double> depth_scale;            ///< As for metres_per_step().
  std::vector<std::string> notes;
};

/// Parses a calibration text: `fx fy cx cy` on one line, behind them either nothing, the width and
/// height, or coefficients of distortion, which only a note takes up; or a matrix of intrinsics in
/// three (or four) rows; or lines `fx 525`, `fy = 525`, `cx: 319.5`, `cy`, `width`, `height`,
/// `depth_scale`. A negative fy, of mirrored images, is kept. kBadInput names the line.
Result<Calibration> parse_calibration_text(std::string_view text,
                                           const std::filesystem::path& path);

/// Parses a PinholeCameraIntrinsic of Open3D: `width`, `height`, `intrinsic_matrix` column by
/// column, and `depth_scale` if there.
Result<Calibration> parse_open3d_camera(std::string_view text, const std::filesystem::path& path);

/// Whether a file is named like a calibration: .json, .yaml, .yml, K.txt, or .txt or .npy with
/// `calib`, `intrinsic` or, at its begin, `camera` in its name, but not `traj`.
bool has_calibration_name(const std::filesystem::path& path);

/// The calibration of a folder: of its .txt files those named like `calibration`, `camera` or
/// `intrinsic`, a camera .json of Open3D, or cam_params.json. Else .json, .yaml and .npy files that
/// have intrinsics (camera_files.h). One whose name says `depth` goes before the others. In a
/// folder `intrinsic` of its own, if there is one, as ScanNet exports have. The
/// scale of the depth may come from another file with the same intrinsics. Nothing where there is
/// none; kBadInput where several differ.
Result<std::optional<Calibration>> find_calibration(const std::filesystem::path& folder);

/// The same of the `cam_params.json`, or .txt files named like `intrinsic`, beside the folder: one
/// for all folders of frames there.
Result<std::optional<Calibration>> find_calibration_beside(const std::filesystem::path& folder);

}  // namespace relief
