#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "relief/scan/result.h"

namespace relief {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// A rotation followed by a translation: x_in_target = target_from_source * x_in_source.
/// Variables are named `target_from_source`, so that chained names cancel.
using RigidMotion = Eigen::Isometry3d;

/// A tangent of a rigid motion: (rotation vector [rad], translation [unit]).
using RigidTangent = Eigen::Matrix<double, 6, 1>;

/// The motion x -> exp([w]) x + v of the tangent (w, v): rotation and translation are decoupled.
RigidMotion motion_from_tangent(const RigidTangent& tangent);

/// The angle of the rotation of `motion`, in [0, pi].
double rotation_angle(const RigidMotion& motion);

/// A proper rotation and a translation from a row-major 4x4 matrix of finite numbers with last row
/// (0, 0, 0, 1). Deviations of R R^T from the identity up to `tolerance` are rounding, and the
/// nearest rotation is taken; beyond it, or for a reflection, the error says what is wrong. `what`
/// names the matrix in it. The default takes entries with three decimals, and the drift of trackers
/// that multiply many motions in single precision (7-Scenes: 2.4e-4).
Result<RigidMotion> rigid_motion_from_matrix(const Eigen::Matrix4d& matrix, const std::string& what,
                                             double tolerance = 2e-3);

/// The rigid motion that minimises sum_i weight_i |target_i - motion * source_i|^2 (Umeyama 1991
/// without scale). Columns are points; `weights` may be empty for all ones. Fewer than three
/// columns, or collinear ones, leave the rotation undetermined: it is then some minimiser.
RigidMotion best_rigid_motion(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target,
                              const Eigen::VectorXd& weights = {});

}  // namespace relief
