#pragma once

#include <filesystem>
#include <string_view>

#include "relief/scan/result.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/rgbd_layouts.h"

namespace relief {

/// Whether a folder is a sequence of Replica: with `depth000000.png` in a folder `results`.
bool has_replica_depths(const std::filesystem::path& folder);

/// The frames of such a folder in the order of their numbers.
RgbdFrames replica_frames(const std::filesystem::path& folder);

/// Parses the `cam_params.json` of Replica's sequences: `fx`, `fy`, `cx`, `cy`, `w`, `h` and
/// `scale` of its `camera`.
Result<Calibration> parse_replica_camera(std::string_view text, const std::filesystem::path& path);

}  // namespace relief
