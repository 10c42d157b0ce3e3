#pragma once

#include <vector>

#include <Eigen/Core>

#include "relief/scan/rigid_motion.h"
#include "relief/simulation/simulate.h"

namespace relief::simulation {

/// The pose of a camera (x right, y down, z forward) at `eye` that looks at `target` with z up in
/// its image. Looking straight up or down, y is up.
RigidMotion camera_looking_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

/// The poses `world_from_view` of `count` cameras that look at `target` from `distance` [unit].
std::vector<RigidMotion> layout_poses(ViewLayout layout, int count, const Eigen::Vector3d& target,
                                      double distance);

}  // namespace relief::simulation
