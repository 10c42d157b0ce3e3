#pragma once

#include <vector>

#include <Eigen/Core>

#include "registration/pairwise/correspondences.h"
#include "registration/pairwise/degenerate_directions.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What two views a and b measured of the same surface, in one frame.
struct SharedSurface {
  std::vector<OrientedPoint> points;     ///< Of one view.
  std::vector<Eigen::Vector3d> normals;  ///< Of the other view, at these points.

  /// From what was found of samples of a in b, and of samples of b in a.
  SharedSurface(const RigidMotion& frame_from_a, const RigidMotion& frame_from_b,
                const Correspondences& in_b, const Correspondences& in_a);
};

}  // namespace relief::registration
