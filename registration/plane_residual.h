#pragma once

#include <Eigen/Core>

#include "scan/rigid_motion.h"

namespace relief {

/// A view's pose as the joint refinement varies it: (qx, qy, qz, qw, mx, my, mz), with
///   x_world - W = R(q) (x_view - c) + m.
/// `c` is the view's own centre and W the centre of all views, so that the numbers are small and
/// rotations hardly shift the view, wherever the world's origin is.
using PoseParameters = Eigen::Matrix<double, 7, 1>;

PoseParameters pose_parameters(const RigidMotion& world_from_view, const Eigen::Vector3d& c,
                               const Eigen::Vector3d& world_centre);
RigidMotion pose_from_parameters(const PoseParameters& parameters, const Eigen::Vector3d& c,
                                 const Eigen::Vector3d& world_centre);

/// One term of the joint refinement, equation (R3):
///   r = scale n_w . (R_s a + m_s - R_t b - m_t),   n_w = R_t n,
/// the distance of a point of view s from the tangent plane of view t, whitened.
struct PlaneResidual {
  Eigen::Vector3d source;  ///< a: the point of view s relative to that view's centre.
  Eigen::Vector3d target;  ///< b: its counterpart, relative to the centre of view t.
  Eigen::Vector3d normal;  ///< n: the unit normal there, frame of view t.
  double scale = 1.0;      ///< sqrt(confidence) / standard deviation [1/unit].

  /// The residual; where not null, the derivatives by the seven parameters of either pose (on the
  /// unit sphere of quaternions only their tangential part means anything).
  double evaluate(const double* source_pose, const double* target_pose, double* by_source,
                  double* by_target) const;

  /// The derivatives by the tangents (w, v) of R <- exp([w]) R, m <- m + v of both poses, (R4).
  void tangents(const double* source_pose, const double* target_pose, RigidTangent& by_source,
                RigidTangent& by_target) const;
};

}  // namespace relief
