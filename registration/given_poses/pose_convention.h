#pragma once

#include <vector>

#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"
#include "scan/views/pose_convention.h"

namespace relief::registration {

/// The convention in which the given poses bring the views together; as given, unless another one
/// is clearly better. Views agree by the part of the samples of each that lies near the surface of
/// the view that it fits best (rough_agreement()), so poses may be guesses. Views that
/// only_rolls() holds for say nothing in other conventions. Tried are
/// view_from_world, the axes of OpenGL, and translations in millimetres, centimetres or metres
/// beside views in another of these. `given`: of the views whose poses count.
PoseConvention find_pose_convention(const std::vector<ViewSurface>& surfaces,
                                    const std::vector<RigidMotion>& poses,
                                    const std::vector<bool>& given);

}  // namespace relief::registration
