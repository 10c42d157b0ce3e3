#include "registration/pairwise/plane_residual.h"

#include <gtest/gtest.h>

namespace relief::registration {
namespace {

struct Example {
  PlaneResidual residual{{0.3, -1.2, 0.7}, {-0.4, 0.9, 1.1}, {0.48, -0.6, 0.64}, 2.5};
  RigidMotion target_from_source;

  Example() {
    RigidTangent a;
    a << 0.3, -0.5, 0.9, 0.6, -0.4, 0.8;
    target_from_source = motion_from_tangent(a);
  }
};

TEST(PlaneResidual, IsTheDistanceFromTheTangentPlane) {
  const Example e;
  RigidTangent derivative;
  const Eigen::Vector3d offset = e.target_from_source * e.residual.source - e.residual.target;
  EXPECT_NEAR(e.residual.evaluate(e.target_from_source, derivative),
              2.5 * e.residual.normal.dot(offset), 1e-12);
}

TEST(PlaneResidual, DerivativeAgreesWithFiniteDifferences) {
  const Example e;
  RigidTangent derivative, unused;
  e.residual.evaluate(e.target_from_source, derivative);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 6; ++k) {
    double values[2];
    for (const int side : {0, 1}) {
      const RigidTangent tangent = (side ? kStep : -kStep) * RigidTangent::Unit(k);
      values[side] =
          e.residual.evaluate(motion_from_tangent(tangent) * e.target_from_source, unused);
    }
    EXPECT_NEAR(derivative[k], (values[1] - values[0]) / (2 * kStep), 1e-8);
  }
}

}  // namespace
}  // namespace relief::registration
