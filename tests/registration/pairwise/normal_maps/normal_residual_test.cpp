#include "registration/pairwise/normal_maps/normal_residual.h"

#include <gtest/gtest.h>

namespace relief::registration {
namespace {

TEST(NormalResidual, DerivativesAgreeWithFiniteDifferences) {
  NormalResidual residual;
  residual.source = {0.3, -1.2, 0.7};
  residual.target = {-0.4, 0.9, 1.1};
  residual.normal = Eigen::Vector3d(0.1, 0.2, -0.9).normalized();
  const Eigen::Vector3d n = Eigen::Vector3d(0.48, -0.6, 0.64).normalized();
  residual.basis.col(0) = n.unitOrthogonal();
  residual.basis.col(1) = n.cross(residual.basis.col(0));
  residual.gradient << 0.2, -0.1, 0.3, 0.4, -0.25, 0.15;
  residual.scale = 2.5;
  RigidTangent a;
  a << 0.3, -0.5, 0.9, 0.6, -0.4, 0.8;
  const RigidMotion target_from_source = motion_from_tangent(a);

  std::array<RigidTangent, 2> derivatives, unused;
  residual.evaluate(target_from_source, derivatives);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 6; ++k) {
    Eigen::Vector2d values[2];
    for (const int side : {0, 1}) {
      const RigidTangent tangent = (side ? kStep : -kStep) * RigidTangent::Unit(k);
      values[side] = residual.evaluate(motion_from_tangent(tangent) * target_from_source, unused);
    }
    const Eigen::Vector2d expected = (values[1] - values[0]) / (2 * kStep);
    EXPECT_NEAR(derivatives[0][k], expected[0], 1e-8);
    EXPECT_NEAR(derivatives[1][k], expected[1], 1e-8);
  }
}

}  // namespace
}  // namespace relief::registration
