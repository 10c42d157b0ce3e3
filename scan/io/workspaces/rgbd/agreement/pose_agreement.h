#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "relief/scan/camera.h"
#include "scan/io/project/view_spec.h"
#include "scan/views/pose_convention.h"

namespace relief {

/// A way to read the depth maps of a project and their poses.
struct DepthReading {
  PinholeIntrinsics intrinsics;
  double factor = 1.0;     ///< Of the scale of each depth map.
  bool along_ray = false;  ///< Depths are distances along the rays, not along the optical axis.
  PoseConvention poses;
};

/// How much depth maps disagree at their poses.
struct Disagreement {
  double median = 0.0;     ///< Of |depth - z| / z over the pixels that meet.
  std::size_t pixels = 0;  ///< That meet.
};

/// How much the depth maps of a few pairs of frames disagree at their poses, for each reading.
/// Pairs at the same pose agree in any reading and are left out. Nothing where too few pixels meet,
/// where frames have no poses, or where they cannot be read.
std::vector<std::optional<Disagreement>> disagreements_at_poses(
    const ProjectSpec& project, const std::vector<DepthReading>& readings);

/// How much better one reading must agree than another to be told from it. Scenes that are their
/// own mirror image agree alike; the views of a room (ICL-NUIM) agree nine times better in a
/// left-handed world, as they are meant.
inline constexpr double kFarBetter = 4.0;

/// What depth cameras err, relative to the depth.
inline constexpr double kCameraError = 0.02;

}  // namespace relief
