#pragma once

#include <Eigen/Core>

#include "registration/plane_residual.h"

namespace relief {

/// Two terms of the joint refinement, equation (R9): the difference of the measured normals of a
/// correspondence between views s and t, in the frame of view t,
///   r_k = scale (e_k . R_t^T R_s N - g_k . (R_t^T (R_s a + m_s - m_t) - b)),  k = 1, 2.
struct NormalResidual {
  using TwoPoses = Eigen::Matrix<double, 2, 7, Eigen::RowMajor>;

  Eigen::Vector3d source;                ///< a: the point of view s relative to that view's centre.
  Eigen::Vector3d target;                ///< b: its counterpart, relative to the centre of view t.
  Eigen::Vector3d normal;                ///< N: the measured normal of view s, in its frame.
  Eigen::Matrix<double, 3, 2> basis;     ///< e_k: tangent to the normal of view t, in its frame.
  Eigen::Matrix<double, 3, 2> gradient;  ///< g_k: of that normal's components, frame of view t.
  double scale = 1.0;                    ///< sqrt(confidence) / standard deviation [1/rad].

  /// The residuals at poses as in PlaneResidual; where not null, the derivatives by the seven
  /// parameters of either pose, two rows each.
  Eigen::Vector2d evaluate(const double* source_pose, const double* target_pose, double* by_source,
                           double* by_target) const;
};

}  // namespace relief
