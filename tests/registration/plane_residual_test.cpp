#include "registration/plane_residual.h"

#include <cmath>

#include <gtest/gtest.h>

namespace relief {
namespace {

struct Example {
  PlaneResidual residual{{0.3, -1.2, 0.7}, {-0.4, 0.9, 1.1}, {0.48, -0.6, 0.64}, 2.5};
  PoseParameters source, target;

  Example() {
    const Eigen::Vector3d c(0.1, 0.2, 3.0), world(5, 6, 7);
    RigidTangent a, b;
    a << 0.3, -0.5, 0.9, 6.0, 4.0, 8.0;
    b << -0.8, 0.2, 0.4, 5.5, 6.5, 7.5;
    source = pose_parameters(motion_from_tangent(a), c, world);
    target = pose_parameters(motion_from_tangent(b), c, world);
  }
  double value() const { return residual.evaluate(source.data(), target.data(), nullptr, nullptr); }
};

TEST(PlaneResidual, PosesSurviveTheirParameters) {
  RigidTangent tangent;
  tangent << 0.3, -0.5, 2.9, 6e5, 4.0, -8e5;
  const RigidMotion pose = motion_from_tangent(tangent);
  const Eigen::Vector3d c(100, 200, 900), world(6e5, 1, -8e5);
  const RigidMotion again = pose_from_parameters(pose_parameters(pose, c, world), c, world);
  EXPECT_TRUE(again.linear().isApprox(pose.linear(), 1e-14));
  EXPECT_LT((again * c - pose * c).norm(), 1e-9);
}

TEST(PlaneResidual, IsTheDistanceFromTheTangentPlane) {
  const Example e;
  const Eigen::Vector3d c(0.1, 0.2, 3.0), world(5, 6, 7);
  const RigidMotion world_from_s = pose_from_parameters(e.source, c, world);
  const RigidMotion world_from_t = pose_from_parameters(e.target, c, world);
  const Eigen::Vector3d x = world_from_s * (e.residual.source + c);
  const Eigen::Vector3d y = world_from_t * (e.residual.target + c);
  const Eigen::Vector3d n = world_from_t.linear() * e.residual.normal;
  EXPECT_NEAR(e.value(), 2.5 * n.dot(x - y), 1e-12);
}

// Moves along the sphere of quaternions, where derivatives by parameters have a meaning.
TEST(PlaneResidual, DerivativesAgreeWithFiniteDifferences) {
  Example e;
  PoseParameters by_source, by_target;
  e.residual.evaluate(e.source.data(), e.target.data(), by_source.data(), by_target.data());
  constexpr double kStep = 1e-6;
  for (auto [pose, derivative] : {std::pair{&e.source, &by_source}, {&e.target, &by_target}}) {
    const PoseParameters at = *pose;
    for (int k = 0; k < 7; ++k) {
      PoseParameters direction = PoseParameters::Unit(k);
      if (k < 4) {
        Eigen::Vector4d tangent = Eigen::Vector4d::Unit(k);
        tangent -= at.head<4>().dot(tangent) * at.head<4>();
        direction.head<4>() = tangent;
      }
      double values[2];
      for (const int side : {0, 1}) {
        *pose = at + (side ? kStep : -kStep) * direction;
        pose->head<4>().normalize();
        values[side] = e.value();
      }
      *pose = at;
      EXPECT_NEAR(derivative->dot(direction), (values[1] - values[0]) / (2 * kStep), 1e-8);
    }
  }
}

TEST(PlaneResidual, TangentsAgreeWithFiniteDifferences) {
  Example e;
  RigidTangent by_source, by_target;
  e.residual.tangents(e.source.data(), e.target.data(), by_source, by_target);
  constexpr double kStep = 1e-6;
  for (auto [pose, derivative] : {std::pair{&e.source, &by_source}, {&e.target, &by_target}}) {
    const PoseParameters at = *pose;
    for (int k = 0; k < 6; ++k) {
      double values[2];
      for (const int side : {0, 1}) {
        RigidTangent tangent = RigidTangent::Zero();
        tangent[k] = side ? kStep : -kStep;
        const RigidMotion step = motion_from_tangent(tangent);
        const Eigen::Quaterniond q(at.data());
        pose->head<4>() = (Eigen::Quaterniond(step.linear()) * q).coeffs();
        pose->tail<3>() = at.tail<3>() + step.translation();
        values[side] = e.value();
      }
      *pose = at;
      EXPECT_NEAR((*derivative)[k], (values[1] - values[0]) / (2 * kStep), 1e-8);
    }
  }
}

}  // namespace
}  // namespace relief
