#include "registration/posegraph/joint/pose_parameters.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace relief::registration {
namespace {

const Eigen::Vector3d kSourceCentre(0.1, 0.2, 3.0), kTargetCentre(-0.3, 0.1, 2.0), kWorld(5, 6, 7);

struct Example {
  RigidMotion world_from_source, world_from_target;
  PoseParameters source, target;

  Example() {
    RigidTangent a, b;
    a << 0.3, -0.5, 0.9, 6.0, 4.0, 8.0;
    b << -0.8, 0.2, 0.4, 5.5, 6.5, 7.5;
    world_from_source = motion_from_tangent(a);
    world_from_target = motion_from_tangent(b);
    source = pose_parameters(world_from_source, kSourceCentre, kWorld);
    target = pose_parameters(world_from_target, kTargetCentre, kWorld);
  }
};

// The tangent of the motion from one relative pose to another, small.
RigidTangent tangent_between(const RigidMotion& from, const RigidMotion& to) {
  const RigidMotion motion = to * from.inverse();
  const Eigen::AngleAxisd turn(motion.linear());
  RigidTangent tangent;
  tangent << turn.angle() * turn.axis(), motion.translation();
  return tangent;
}

TEST(PoseParameters, ArePosesWrittenDifferently) {
  RigidTangent tangent;
  tangent << 0.3, -0.5, 2.9, 6e5, 4.0, -8e5;
  const RigidMotion pose = motion_from_tangent(tangent);
  const Eigen::Vector3d c(100, 200, 900), world(6e5, 1, -8e5);
  const RigidMotion again = pose_from_parameters(pose_parameters(pose, c, world), c, world);
  EXPECT_TRUE(again.linear().isApprox(pose.linear(), 1e-14));
  EXPECT_LT((again * c - pose * c).norm(), 1e-9);
}

TEST(PoseParameters, GiveRelativePosesAboutCentres) {
  const Example e;
  const Eigen::Vector3d x(0.7, -0.4, 1.1);
  const Eigen::Vector3d expected =
      e.world_from_target.inverse() * e.world_from_source * (x + kSourceCentre) - kTargetCentre;
  EXPECT_LT((relative_pose(e.source, e.target) * x - expected).norm(), 1e-12);
}

// Along the sphere of quaternions, where derivatives by parameters have a meaning.
TEST(PoseParameters, TangentsAgreeWithFiniteDifferences) {
  Example e;
  const RigidMotion before = relative_pose(e.source, e.target);
  const auto by_source = tangent_by_source(e.source, e.target);
  const auto by_target = tangent_by_target(e.target);
  constexpr double kStep = 1e-6;
  for (auto [pose, derivative] : {std::pair{&e.source, &by_source}, {&e.target, &by_target}}) {
    const PoseParameters at = *pose;
    for (int k = 0; k < 7; ++k) {
      PoseParameters direction = PoseParameters::Unit(k);
      if (k < 4) direction.head<4>() -= at[k] * at.head<4>();
      RigidTangent values[2];
      for (const int side : {0, 1}) {
        *pose = at + (side ? kStep : -kStep) * direction;
        pose->head<4>().normalize();
        values[side] = tangent_between(before, relative_pose(e.source, e.target));
      }
      *pose = at;
      const RigidTangent expected = (values[1] - values[0]) / (2 * kStep);
      EXPECT_LT((*derivative * direction - expected).norm(), 1e-8) << "parameter " << k;
    }
  }
}

}  // namespace
}  // namespace relief::registration
