#pragma once

#include <string>

#include "relief/scan/result.h"
#include "scan/io/project/view_spec.h"
#include "scan/io/workspaces/rgbd/agreement/pose_agreement.h"

namespace relief {

/// To the metre: what most cameras write.
inline constexpr double kMillimetres = 1000.0;

/// A scale of depth maps that nobody stated.
struct AssumedDepthScale {
  double metres_per_value = 0.0;
  std::string note;  ///< For the user: what was taken, why, and the option that says otherwise.
};

/// The scale of the depth maps of a folder without one, whose views have a scale of 1: `usual`
/// values per metre where they hold 16-bit integers, eight times as many where all of these are
/// multiples of 8, as in SUN3D; else metres, or millimetres where the depths
/// are tens of metres otherwise. Where the maps agree with their poses far better in another usual
/// scale, that one. kBadInput where the first map cannot be read or has 8 bits. `project` has
/// views, with depth maps and cameras.
Result<AssumedDepthScale> assume_depth_scale(const ProjectSpec& project, double usual,
                                             const ComparedDepths& compared);

}  // namespace relief
