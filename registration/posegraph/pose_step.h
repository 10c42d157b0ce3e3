#pragma once

#include <vector>

#include <Eigen/Core>

#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The mean of the views' centres, world frame: the centre of their tangents.
Eigen::Vector3d common_centre(const std::vector<const ViewSurface*>& surfaces,
                              const std::vector<RigidMotion>& world_from_view);

/// A pose after the motion of a tangent about a centre, world frame. Its rotation is free of
/// rounding.
RigidMotion moved(const RigidMotion& world_from_view, const RigidTangent& tangent,
                  const Eigen::Vector3d& centre);

/// What a motion of the world moves at a centre, as a tangent about it ([rad], [unit]).
RigidTangent tangent_at(const RigidMotion& motion, const Eigen::Vector3d& centre);

/// Turns tangents about a centre into tangents about the point at `point_from_centre` from it, both
/// in the same axes.
Matrix6d tangents_about(const Eigen::Vector3d& point_from_centre);

}  // namespace relief::registration
