#include "registration/normal_residual.h"

#include <Eigen/Geometry>

namespace relief {

namespace {

// What a derivative by the tangent (w, v) of R <- exp([w]) R, m <- m + v is by the parameters: on
// the sphere of unit quaternions, (w / 2, 0) q is the direction of a turn w.
Eigen::Matrix<double, 1, 7> by_parameters(const RigidTangent& tangent, const double* pose) {
  const Eigen::Map<const Eigen::Quaterniond> q(pose);
  const Eigen::Quaterniond turn(0.0, tangent[0], tangent[1], tangent[2]);
  Eigen::Matrix<double, 1, 7> row;
  row.head<4>() = 2.0 * (turn * q).coeffs().transpose();
  row.tail<3>() = tangent.tail<3>().transpose();
  return row;
}

}  // namespace

Eigen::Vector2d NormalResidual::evaluate(const double* source_pose, const double* target_pose,
                                         double* by_source, double* by_target) const {
  const Eigen::Map<const Eigen::Quaterniond> q_s(source_pose), q_t(target_pose);
  const Eigen::Map<const Eigen::Vector3d> m_s(source_pose + 4), m_t(target_pose + 4);
  const Eigen::Vector3d turned = q_s * source, n_world = q_s * normal;
  const Eigen::Vector3d offset = turned + m_s - m_t;
  const Eigen::Matrix3d target_from_world = q_t.conjugate().toRotationMatrix();
  for (int k = 0; k < 2 && (by_source || by_target); ++k) {
    const Eigen::Vector3d e = scale * (q_t * basis.col(k)), g = scale * (q_t * gradient.col(k));
    RigidTangent source_tangent, target_tangent;
    source_tangent << n_world.cross(e) - turned.cross(g), -g;
    target_tangent << e.cross(n_world) - g.cross(offset), g;
    if (by_source)
      Eigen::Map<TwoPoses>(by_source).row(k) = by_parameters(source_tangent, source_pose);
    if (by_target)
      Eigen::Map<TwoPoses>(by_target).row(k) = by_parameters(target_tangent, target_pose);
  }
  return scale * (basis.transpose() * (target_from_world * n_world) -
                  gradient.transpose() * (target_from_world * offset - target));
}

}  // namespace relief
