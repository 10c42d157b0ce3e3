#pragma once

#include <filesystem>
#include <optional>

#include "relief/scan/result.h"
#include "scan/io/workspaces/rgbd/recordings/recording.h"

namespace relief {

/// Reads `camera_matrix.csv` and `odometry.csv` of a recording by Stray Scanner (LiDAR of
/// telephones). The matrix is of the video, 1920 x 1440; depth maps are 256 x 192, in millimetres.
/// Odometry has the poses of cameras with y down and z ahead, a line for each frame: time, frame,
/// x y z [m], qx qy qz qw, and in later versions fx fy cx cy of the video. Images of `confidence`
/// are 0, 1 or 2; those of 0 are of surfaces that were guessed. Nothing where the folder has no
/// camera_matrix.csv. kBadInput names the line that is wrong.
Result<std::optional<Recording>> read_stray_scanner(const std::filesystem::path& folder);

}  // namespace relief
