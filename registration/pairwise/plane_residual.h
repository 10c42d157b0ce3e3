#pragma once

#include <Eigen/Core>

#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// One term of the joint refinement, equation (R3), in the frame of view t:
///   r = scale n . (R a + m - b),
/// the distance of a point of view s from the tangent plane of view t, whitened, at a pose
/// x_t - c_t = R (x_s - c_s) + m of s relative to t.
struct PlaneResidual {
  Eigen::Vector3d source;  ///< a: the point of view s relative to that view's centre.
  Eigen::Vector3d target;  ///< b: its counterpart, relative to the centre of view t.
  Eigen::Vector3d normal;  ///< n: the unit normal there, frame of view t.
  double scale = 1.0;      ///< sqrt(confidence) / standard deviation [1/unit].

  /// The residual and its derivative by a motion of view s relative to view t, a tangent (w, v)
  /// about c_t in the axes of t, (R4).
  double evaluate(const RigidMotion& target_from_source, RigidTangent& derivative) const {
    const Eigen::Vector3d moved = target_from_source * source, pull = scale * normal;
    derivative << moved.cross(pull), pull;
    return pull.dot(moved - target);
  }
};

}  // namespace relief::registration
