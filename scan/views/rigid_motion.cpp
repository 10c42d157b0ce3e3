#include "relief/scan/rigid_motion.h"

#include <cassert>
#include <cmath>
#include <sstream>

#include <Eigen/SVD>

namespace relief {

RigidMotion motion_from_tangent(const RigidTangent& tangent) {
  const Eigen::Vector3d rotation = tangent.head<3>();
  const double angle = rotation.norm();
  RigidMotion motion = RigidMotion::Identity();
  if (angle > 0.0) motion.linear() = Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix();
  motion.translation() = tangent.tail<3>();
  return motion;
}

double rotation_angle(const RigidMotion& motion) {
  const Eigen::Quaterniond q(motion.linear());
  return 2.0 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

namespace {

Error not_rigid(const std::string& what, const std::string& why) {
  return {ErrorKind::kBadInput, what + " is not a rigid motion: " + why};
}

}  // namespace

Result<RigidMotion> rigid_motion_from_matrix(const Eigen::Matrix4d& matrix, const std::string& what,
                                             double tolerance) {
  if (!matrix.allFinite()) return not_rigid(what, "it has a NaN or infinite entry");
  if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    return not_rigid(what, "its last row must be 0 0 0 1");
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const double deviation =
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (deviation > tolerance) {
    std::ostringstream why;
    why << "R R^T deviates from the identity by " << deviation << " (at most " << tolerance
        << " is taken for rounding); remove scale and shear from its 3x3 part";
    return not_rigid(what, why.str());
  }
  if (rotation.determinant() < 0.0)
    return not_rigid(what, "its 3x3 part is a reflection (determinant -1)");

  RigidMotion motion = RigidMotion::Identity();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  motion.linear() = svd.matrixU() * svd.matrixV().transpose();
  motion.translation() = matrix.topRightCorner<3, 1>();
  return motion;
}

RigidMotion best_rigid_motion(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target,
                              const Eigen::VectorXd& weights) {
  assert(source.cols() == target.cols());
  assert(weights.size() == 0 || weights.size() == source.cols());
  if (source.cols() == 0) return RigidMotion::Identity();
  const Eigen::VectorXd w = weights.size() ? weights : Eigen::VectorXd::Ones(source.cols()).eval();
  const double total = w.sum();
  const Eigen::Vector3d source_mean = source * w / total;
  const Eigen::Vector3d target_mean = target * w / total;
  const Eigen::Matrix3d covariance = (target.colwise() - target_mean) * w.asDiagonal() *
                                     (source.colwise() - source_mean).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) sign.z() = -1.0;

  RigidMotion target_from_source = RigidMotion::Identity();
  target_from_source.linear() = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  target_from_source.translation() = target_mean - target_from_source.linear() * source_mean;
  return target_from_source;
}

}  // namespace relief
