#include "registration/given_poses/hand_eye.h"

#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/align_surfaces.h"
#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

RigidMotion motion(double degrees, const Eigen::Vector3d& axis, const Eigen::Vector3d& shift) {
  return Eigen::Translation3d(shift) * Eigen::AngleAxisd(degrees * kDegree, axis.normalized());
}

// Sensors that look at the origin; if tilted, from different distances.
std::vector<RigidMotion> poses_round_the_origin(int count, double tilt) {
  std::vector<RigidMotion> poses;
  for (int i = 0; i < count; ++i)
    poses.push_back(motion(360.0 / count * i, {0, 1, 0}, {0, 0, 0}) *
                    motion(tilt * (i % 3), {1, 0, 0}, {0, 0, 0}) *
                    Eigen::Translation3d(0, 0, -500 - tilt * (i % 5)));
  return poses;
}

// What is written of true poses whose errors are those of `wrong`, in another world.
std::vector<GivenAndFound> views_with(const std::vector<RigidMotion>& truth, const HandEye& wrong) {
  std::vector<GivenAndFound> views;
  for (const RigidMotion& pose : truth) {
    GivenAndFound view;
    view.given = pose * wrong.body_from_view.inverse();
    view.given.translation() /= wrong.scale;
    view.found = motion(40, {1, 2, 0}, {5, 6, 7}) * pose;
    view.centre = {0, 0, 500};
    views.push_back(view);
  }
  return views;
}

RigidMotion corrected(RigidMotion given, const HandEye& hand_eye) {
  given.translation() *= hand_eye.scale;
  return given * hand_eye.body_from_view;
}

// Relative poses in the corrected world are those that were found.
void expect_corrected(const std::vector<GivenAndFound>& views, const HandEye& hand_eye,
                      double tolerance) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    const RigidMotion expected = views[0].found.inverse() * views[i].found;
    const RigidMotion motion =
        corrected(views[0].given, hand_eye).inverse() * corrected(views[i].given, hand_eye);
    EXPECT_LT((motion * views[i].centre - expected * views[i].centre).norm(), tolerance) << i;
    EXPECT_LT(rotation_angle(motion.inverse() * expected), 1e-3 * tolerance) << i;
  }
}

TEST(HandEye, IsFoundFromExactPoses) {
  for (const double tilt : {0.0, 15.0}) {  // A turntable, and sensors at several heights.
    const auto truth = poses_round_the_origin(8, tilt);
    for (const HandEye& wrong :
         {HandEye{1.0, motion(1.2, {1, 1, 0}, {25, 0, 3})},
          HandEye{1.0, motion(90, {0, 0, 1}, {60, -20, 0})},
          HandEye{1.0, motion(180, {0, 0, 1}, {0, 0, 0})}, HandEye{0.95, RigidMotion::Identity()},
          HandEye{1.1, motion(30, {0, 1, 3}, {10, 20, 30})}}) {
      const auto views = views_with(truth, wrong);
      const auto found = calibrate_hand_eye(views);
      ASSERT_TRUE(found);
      expect_corrected(views, *found, 1e-6);
      if (tilt > 0.0) {
        EXPECT_NEAR(found->scale, wrong.scale, 1e-9);
      }
    }
  }
}

TEST(HandEye, OfAScaleIsTheScaleAlone) {
  const auto views = views_with(poses_round_the_origin(6, 15.0), {1.05, RigidMotion::Identity()});
  const auto found = calibrate_hand_eye(views);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->body_from_view.matrix(), RigidMotion::Identity().matrix());
}

TEST(HandEye, WithstandsAWrongPoseAndNoise) {
  auto views =
      views_with(poses_round_the_origin(9, 15.0), {1.0, motion(90, {0, 0, 1}, {60, -20, 0})});
  for (std::size_t i = 0; i < views.size(); ++i)
    views[i].found = views[i].found * motion(0.02, {1.0 * (i % 2), 1, 1}, {0.1, 0.1 * (i % 3), 0});
  views[4].found = views[4].found * motion(20, {0, 1, 0}, {30, 0, 0});
  const auto found = calibrate_hand_eye(views);
  ASSERT_TRUE(found);
  views.erase(views.begin() + 4);
  expect_corrected(views, *found, 2.0);
}

TEST(HandEye, IsNotFoundWherePosesErrEachInItsOwnWay) {
  const auto truth = poses_round_the_origin(8, 15.0);
  auto views = views_with(truth, {});
  EXPECT_FALSE(calibrate_hand_eye(views)) << "nothing is wrong";
  for (std::size_t i = 0; i < views.size(); ++i)
    views[i].given = views[i].given * motion(3, {1.0 * (i % 2), 1.0 * (i % 3), 1.0 * (i % 5)},
                                             {20.0 * (i % 4), 0, 10.0 * (i % 3)});
  EXPECT_FALSE(calibrate_hand_eye(views));
  views.resize(2);
  EXPECT_FALSE(calibrate_hand_eye(views));
}

// Refining such guesses alone brings bumps together that do not belong together, view by view.
TEST(HandEye, OfARobotIsFoundFromViewsThatShapePlaces) {
  const auto ring = testing::ring_of_views({.pixels = 96});
  const std::vector<RigidMotion> truth = testing::poses_of(ring);
  const RigidMotion body_from_view = motion(10, {1, 0, 1}, {10, 20, 0});
  auto views = ring;
  for (RangeView& view : views)
    view.world_from_view = view.world_from_view * body_from_view.inverse();
  const auto aligned = align_views(views, {});
  ASSERT_TRUE(aligned) << aligned.error().message;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const RigidMotion relative =
        aligned->views[0].world_from_view.inverse() * aligned->views[i].world_from_view;
    EXPECT_LT(rotation_angle(relative.inverse() * truth[0].inverse() * truth[i]), 0.01) << i;
    EXPECT_EQ(aligned->views[i].status, PoseStatus::kVerified) << i;
  }
}

TEST(HandEye, OfOneScaleIsTaken) {
  auto views = testing::ring_of_views({.pixels = 96});
  for (RangeView& view : views) view.world_from_view.translation() /= 1.15;
  const auto aligned = align_views(views, {});
  ASSERT_TRUE(aligned) << aligned.error().message;
  EXPECT_EQ(verified_views(*aligned), views.size());
  EXPECT_THAT(aligned->notes, Contains(HasSubstr("translations times 1.15")));
}

}  // namespace
}  // namespace relief::registration
