#include "registration/normal_residual.h"

#include <gtest/gtest.h>

namespace relief {
namespace {

struct Example {
  NormalResidual residual;
  PoseParameters source, target;

  Example() {
    residual.source = {0.3, -1.2, 0.7};
    residual.target = {-0.4, 0.9, 1.1};
    residual.normal = Eigen::Vector3d(0.1, 0.2, -0.9).normalized();
    const Eigen::Vector3d n = Eigen::Vector3d(0.48, -0.6, 0.64).normalized();
    residual.basis.col(0) = n.unitOrthogonal();
    residual.basis.col(1) = n.cross(residual.basis.col(0));
    residual.gradient << 0.2, -0.1, 0.3, 0.4, -0.25, 0.15;
    residual.scale = 2.5;
    const Eigen::Vector3d c(0.1, 0.2, 3.0), world(5, 6, 7);
    RigidTangent a, b;
    a << 0.3, -0.5, 0.9, 6.0, 4.0, 8.0;
    b << -0.8, 0.2, 0.4, 5.5, 6.5, 7.5;
    source = pose_parameters(motion_from_tangent(a), c, world);
    target = pose_parameters(motion_from_tangent(b), c, world);
  }
  Eigen::Vector2d value() const {
    return residual.evaluate(source.data(), target.data(), nullptr, nullptr);
  }
};

TEST(NormalResidual, DerivativesAgreeWithFiniteDifferences) {
  Example e;
  NormalResidual::TwoPoses by_source, by_target;
  e.residual.evaluate(e.source.data(), e.target.data(), by_source.data(), by_target.data());
  constexpr double kStep = 1e-6;
  for (auto [pose, derivative] : {std::pair{&e.source, &by_source}, {&e.target, &by_target}}) {
    const PoseParameters at = *pose;
    for (int k = 0; k < 7; ++k) {
      PoseParameters direction = PoseParameters::Unit(k);
      if (k < 4) {  // Along the sphere of quaternions, where derivatives have a meaning.
        Eigen::Vector4d tangent = Eigen::Vector4d::Unit(k);
        tangent -= at.head<4>().dot(tangent) * at.head<4>();
        direction.head<4>() = tangent;
      }
      Eigen::Vector2d values[2];
      for (const int side : {0, 1}) {
        *pose = at + (side ? kStep : -kStep) * direction;
        pose->head<4>().normalize();
        values[side] = e.value();
      }
      *pose = at;
      const Eigen::Vector2d expected = (values[1] - values[0]) / (2 * kStep);
      EXPECT_LT((*derivative * direction - expected).norm(), 1e-8) << "parameter " << k;
    }
  }
}

TEST(NormalResidual, DoesNotChangeWhenBothViewsMoveTogether) {
  Example e;
  const Eigen::Vector2d before = e.value();
  RigidTangent tangent;
  tangent << 0.4, -1.0, 0.6, 3.0, -2.0, 5.0;
  const RigidMotion motion = motion_from_tangent(tangent);
  for (auto* pose : {&e.source, &e.target}) {
    const Eigen::Quaterniond q(pose->data());
    const Eigen::Vector3d m = pose->tail<3>();
    pose->head<4>() = (Eigen::Quaterniond(motion.linear()) * q).coeffs();
    pose->tail<3>() = motion * m;
  }
  EXPECT_LT((e.value() - before).norm(), 1e-12);
}

}  // namespace
}  // namespace relief
