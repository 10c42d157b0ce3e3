#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "relief/scan/result.h"
#include "scan/io/workspaces/rgbd/calibration.h"
#include "scan/io/workspaces/rgbd/trajectories.h"

namespace relief {

/// What the `metadata.json` of a recording by Record3D (LiDAR and TrueDepth cameras of telephones)
/// says.
struct Record3dMetadata {
  /// Of the depth maps: `K` is that of the colour images, which are larger.
  Calibration calibration;
  /// By the number of a frame, which is the name of its files; world from view.
  std::map<std::string, TrajectoryPose> poses;
};

/// Reads the `metadata.json` of a folder: `K` column by column for images of `w` by `h`, depth maps
/// of `dw` by `dh`, `poses` as qx qy qz qw tx ty tz with y up and z back. Nothing where the folder
/// has none with a `K`. kBadInput names what is wrong in it.
Result<std::optional<Record3dMetadata>> read_record3d_metadata(const std::filesystem::path& folder);

}  // namespace relief
