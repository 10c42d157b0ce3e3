#pragma once

#include <Eigen/Core>

#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// A view's pose as the joint refinement varies it: (qx, qy, qz, qw, mx, my, mz), with
///   x_world - W = R(q) (x_view - c) + m.
/// `c` is the view's own centre and W the centre of all views, so that the numbers are small and
/// rotations hardly shift the view, wherever the world's origin is.
using PoseParameters = Eigen::Matrix<double, 7, 1>;

PoseParameters pose_parameters(const RigidMotion& world_from_view, const Eigen::Vector3d& c,
                               const Eigen::Vector3d& world_centre);
RigidMotion pose_from_parameters(const PoseParameters& parameters, const Eigen::Vector3d& c,
                                 const Eigen::Vector3d& world_centre);

/// The pose of view s relative to view t, both about their centres: x_t - c_t = R (x_s - c_s) + m.
RigidMotion relative_pose(const PoseParameters& source, const PoseParameters& target);

/// What turns derivatives by a motion of view s relative to view t, a tangent (w, v) about c_t in
/// the axes of t, into those by the parameters of either pose: dr/dq = dr/d(w, v) times this. On
/// the sphere of unit quaternions only the tangential part of derivatives means anything.
using TangentByParameters = Eigen::Matrix<double, 6, 7>;
TangentByParameters tangent_by_source(const PoseParameters& source, const PoseParameters& target);
TangentByParameters tangent_by_target(const PoseParameters& target);

}  // namespace relief::registration
