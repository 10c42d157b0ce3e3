#include "relief/scan/rigid_motion.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"

namespace relief {
namespace {

RigidMotion some_motion() {
  RigidTangent tangent;
  tangent << 0.3, -1.1, 0.7, 10, -20, 30;
  return motion_from_tangent(tangent);
}

TEST(RigidMotion, AngleOfATangentIsItsLength) {
  RigidTangent tangent = RigidTangent::Zero();
  tangent.head<3>() << 0.1, 0.2, -0.2;
  EXPECT_NEAR(rotation_angle(motion_from_tangent(tangent)), 0.3, 1e-14);
  EXPECT_EQ(rotation_angle(motion_from_tangent(RigidTangent::Zero())), 0.0);
}

TEST(RigidMotion, FromMatrixTakesRoundingAndNothingElse) {
  Eigen::Matrix4d matrix = some_motion().matrix();
  ASSERT_THAT(rigid_motion_from_matrix(matrix.cast<float>().cast<double>(), "pose"), IsOk());

  const Eigen::Matrix4d three_decimals = (matrix * 1000.0).array().round() / 1000.0;
  const auto rounded = rigid_motion_from_matrix(three_decimals, "pose");
  ASSERT_THAT(rounded, IsOk());
  EXPECT_LT(rotation_angle(*rounded * some_motion().inverse()), 1e-3);

  Eigen::Matrix4d scaled = matrix;
  scaled.topLeftCorner<3, 3>() *= 1.01;
  EXPECT_THAT(rigid_motion_from_matrix(scaled, "pose"), HasError());

  Eigen::Matrix4d mirrored = matrix;
  mirrored.col(0) *= -1.0;
  EXPECT_THAT(rigid_motion_from_matrix(mirrored, "view v001: world_from_view"),
              HasError("v001", "reflection"));

  Eigen::Matrix4d broken = matrix;
  broken(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(rigid_motion_from_matrix(broken, "pose"), HasError());
  Eigen::Matrix4d projective = matrix;
  projective(3, 0) = 0.5;
  EXPECT_THAT(rigid_motion_from_matrix(projective, "pose"), HasError());
}

TEST(RigidMotion, BestRigidMotionRecoversTheMotionOfPoints) {
  const Eigen::Matrix3Xd source = Eigen::Matrix3Xd::Random(3, 20);
  const RigidMotion truth = some_motion();
  const Eigen::Matrix3Xd target = truth * source;
  EXPECT_TRUE(best_rigid_motion(source, target).isApprox(truth, 1e-12));
}

TEST(RigidMotion, BestRigidMotionIsNeverAReflection) {
  const Eigen::Matrix3Xd source = Eigen::Matrix3Xd::Random(3, 20);
  Eigen::Matrix3Xd mirrored = source;
  mirrored.row(0) *= -1.0;
  EXPECT_NEAR(best_rigid_motion(source, mirrored).linear().determinant(), 1.0, 1e-12);
}

}  // namespace
}  // namespace relief
