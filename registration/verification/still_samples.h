#pragma once

#include <vector>

#include "relief/scan/range_view.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The fraction of the samples of `view` that stand still in the frame of its camera: most of
/// `others` of the same camera, of which some are compared, have their sample at the same pixel
/// within `tolerance` [unit], but their poses move it by more than twice that. 0 where fewer than
/// two others have the same rays.
double still_fraction(const RangeView& view, const RigidMotion& world_from_view,
                      const std::vector<const RangeView*>& others,
                      const std::vector<RigidMotion>& world_from_others, double tolerance);

}  // namespace relief::registration
