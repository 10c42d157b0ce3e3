#include "registration/plane_residual.h"

#include <Eigen/Geometry>

namespace relief {

namespace {

struct Pose {
  explicit Pose(const double* parameters) : q(parameters), m(parameters + 4) {}
  Eigen::Map<const Eigen::Quaterniond> q;
  Eigen::Map<const Eigen::Vector3d> m;
};

// d(R(q) x) / d(qx, qy, qz, qw) of R(q) x = x + 2 w (u x x) + 2 u x (u x x), q = (u, w), to the
// left multiplied by the row y^T.
Eigen::RowVector4d rotation_derivative(const Eigen::RowVector3d& y, const Eigen::Quaterniond& q,
                                       const Eigen::Vector3d& x) {
  const Eigen::Vector3d u = q.vec();
  Eigen::RowVector4d row;
  // 2 w (du x x): y . (du x x) = du . (x cross y).
  // 2 d[u x (u x x)] = 2 d[u (u.x) - x (u.u)] = 2 [du (u.x) + u (du.x) - 2 x (u.du)].
  const Eigen::Vector3d yt = y.transpose();
  row.head<3>() =
      2.0 * (q.w() * x.cross(yt) + u.dot(x) * yt + yt.dot(u) * x - 2.0 * yt.dot(x) * u).transpose();
  row[3] = 2.0 * yt.dot(u.cross(x));
  return row;
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
  const Pose pose(parameters.data());
  RigidMotion world_from_view = RigidMotion::Identity();
  world_from_view.linear() = pose.q.normalized().toRotationMatrix();
  world_from_view.translation() = pose.m + world_centre - world_from_view.linear() * c;
  return world_from_view;
}

double PlaneResidual::evaluate(const double* source_pose, const double* target_pose,
                               double* by_source, double* by_target) const {
  const Pose s(source_pose), t(target_pose);
  const Eigen::Vector3d n_world = t.q * normal;
  // Relative to the centre of view t, whose rotation then only turns the normal: n_w . R_t b = n .
  // b.
  const Eigen::Vector3d offset = s.q * source + s.m - t.m;
  if (by_source) {
    Eigen::Map<Eigen::Matrix<double, 1, 7>> row(by_source);
    row.head<4>() = scale * rotation_derivative(n_world.transpose(), s.q, source);
    row.tail<3>() = scale * n_world.transpose();
  }
  if (by_target) {
    Eigen::Map<Eigen::Matrix<double, 1, 7>> row(by_target);
    row.head<4>() = scale * rotation_derivative(offset.transpose(), t.q, normal);
    row.tail<3>() = -scale * n_world.transpose();
  }
  return scale * (n_world.dot(offset) - normal.dot(target));
}

void PlaneResidual::tangents(const double* source_pose, const double* target_pose,
                             RigidTangent& by_source, RigidTangent& by_target) const {
  const Pose s(source_pose), t(target_pose);
  const Eigen::Vector3d n_world = t.q * normal;
  const Eigen::Vector3d turned = s.q * source;
  const Eigen::Vector3d offset = turned + s.m - t.m;
  by_source << scale * turned.cross(n_world), scale * n_world;
  by_target << scale * n_world.cross(offset), -scale * n_world;
}

}  // namespace relief
