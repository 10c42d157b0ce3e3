#pragma once

#include <optional>
#include <vector>

#include "relief/scan/camera.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// A way to read the depth maps of a project.
struct DepthReading {
  PinholeIntrinsics intrinsics;
  double factor = 1.0;     ///< Of the scale of each depth map.
  bool along_ray = false;  ///< Depths are distances along the rays, not along the optical axis.
};

/// How much the depth maps disagree at their poses, for each reading: the median of |depth - z| / z
/// over a few pairs of frames. Nothing where too few pixels meet, where frames have no poses, or
/// where they cannot be read.
std::vector<std::optional<double>> disagreements_at_poses(
    const ProjectSpec& project, const std::vector<DepthReading>& readings);

/// How much better one reading must agree than another to be told from it. Scenes that are their
/// own mirror image agree alike; of the views of a room (ICL-NUIM) the right sign of fy agrees nine
/// times better.
inline constexpr double kFarBetter = 4.0;

}  // namespace relief
