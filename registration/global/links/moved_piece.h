#pragma once

#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Whether a pose tells that the sensor stood still, while a piece of what it saw moved: one of two
/// views has samples that hang together in front of what the other saw there.
///
/// What stands still, as a table, fits at that pose wherever the object was turned to. `min_stddev`
/// as in JudgeOptions. False where neither sensor has a projection.
bool moved_before_still_sensor(const ViewSurface& a, const ViewSurface& b,
                               const RigidMotion& b_from_a, double min_stddev = 0.0);

}  // namespace relief::registration
