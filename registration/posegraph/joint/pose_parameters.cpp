#include "registration/posegraph/joint/pose_parameters.h"

#include <Eigen/Geometry>

namespace relief::registration {

namespace {

Eigen::Quaterniond rotation_of(const PoseParameters& pose) {
  return Eigen::Quaterniond(pose.head<4>());
}

// (w, v) in world axes about the view's own centre by the parameters: on the sphere of unit
// quaternions, (w / 2, 0) q is the direction of a turn w.
TangentByParameters own_tangent(const PoseParameters& pose) {
  TangentByParameters tangent = TangentByParameters::Zero();
  for (int k = 0; k < 3; ++k) {
    Eigen::Quaterniond turn(0.0, 0.0, 0.0, 0.0);
    turn.coeffs()[k] = 2.0;
    tangent.block<1, 4>(k, 0) = (turn * rotation_of(pose)).coeffs().transpose();
  }
  tangent.bottomRightCorner<3, 3>().setIdentity();
  return tangent;
}

Eigen::Matrix3d cross_product_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return matrix;
}

}  // namespace

PoseParameters pose_parameters(const RigidMotion& world_from_view, const Eigen::Vector3d& c,
                               const Eigen::Vector3d& world_centre) {
  PoseParameters parameters;
  parameters.head<4>() = Eigen::Quaterniond(world_from_view.linear()).normalized().coeffs();
  parameters.tail<3>() = world_from_view * c - world_centre;
  return parameters;
}

RigidMotion pose_from_parameters(const PoseParameters& parameters, const Eigen::Vector3d& c,
                                 const Eigen::Vector3d& world_centre) {
  RigidMotion world_from_view = RigidMotion::Identity();
  world_from_view.linear() = rotation_of(parameters).normalized().toRotationMatrix();
  world_from_view.translation() =
      parameters.tail<3>() + world_centre - world_from_view.linear() * c;
  return world_from_view;
}

RigidMotion relative_pose(const PoseParameters& source, const PoseParameters& target) {
  const Eigen::Matrix3d target_from_world = rotation_of(target).conjugate().toRotationMatrix();
  RigidMotion target_from_source = RigidMotion::Identity();
  target_from_source.linear() = target_from_world * rotation_of(source).toRotationMatrix();
  target_from_source.translation() = target_from_world * (source.tail<3>() - target.tail<3>());
  return target_from_source;
}

// A turn w of the source about its own centre, at the offset o from the target's, moves what lies
// at the target's centre by -w x o.
TangentByParameters tangent_by_source(const PoseParameters& source, const PoseParameters& target) {
  const Eigen::Matrix3d target_from_world = rotation_of(target).conjugate().toRotationMatrix();
  Eigen::Matrix<double, 6, 6> about_target = Eigen::Matrix<double, 6, 6>::Zero();
  about_target.topLeftCorner<3, 3>() = target_from_world;
  about_target.bottomLeftCorner<3, 3>() =
      target_from_world * cross_product_matrix(source.tail<3>() - target.tail<3>());
  about_target.bottomRightCorner<3, 3>() = target_from_world;
  return about_target * own_tangent(source);
}

TangentByParameters tangent_by_target(const PoseParameters& target) {
  const Eigen::Matrix3d target_from_world = rotation_of(target).conjugate().toRotationMatrix();
  TangentByParameters tangent = own_tangent(target);
  tangent.topRows<3>() = -target_from_world * tangent.topRows<3>();
  tangent.bottomRows<3>() = -target_from_world * tangent.bottomRows<3>();
  return tangent;
}

}  // namespace relief::registration
