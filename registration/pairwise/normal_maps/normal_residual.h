#pragma once

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Two terms of the joint refinement, equation (R9): the difference of the measured normals of a
/// correspondence between views s and t, in the frame of view t,
///   r_k = scale (e_k . R N - g_k . (R a + m - b)),  k = 1, 2,
/// at a pose of s relative to t as in PlaneResidual.
struct NormalResidual {
  Eigen::Vector3d source;                ///< a: the point of view s relative to that view's centre.
  Eigen::Vector3d target;                ///< b: its counterpart, relative to the centre of view t.
  Eigen::Vector3d normal;                ///< N: the measured normal of view s, in its frame.
  Eigen::Matrix<double, 3, 2> basis;     ///< e_k: tangent to the normal of view t, in its frame.
  Eigen::Matrix<double, 3, 2> gradient;  ///< g_k: of that normal's components, frame of view t.
  double scale = 1.0;                    ///< sqrt(confidence) / standard deviation [1/rad].

  /// The residuals and their derivatives by a motion of view s relative to view t, tangents (w, v)
  /// about c_t in the axes of t.
  Eigen::Vector2d evaluate(const RigidMotion& target_from_source,
                           std::array<RigidTangent, 2>& derivatives) const {
    const Eigen::Vector3d moved = target_from_source * source;
    const Eigen::Vector3d turned = target_from_source.linear() * normal;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector3d e = scale * basis.col(k), g = scale * gradient.col(k);
      derivatives[static_cast<std::size_t>(k)] << turned.cross(e) - moved.cross(g), -g;
    }
    return scale * (basis.transpose() * turned - gradient.transpose() * (moved - target));
  }
};

}  // namespace relief::registration
