#include "registration/verification/given_pose_notes.h"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scenes/synthetic_views.h"

namespace relief::registration {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Views round an object at uneven heights, found where they are given, but for errors of `noise` in
// each coordinate and in a world of its own.
std::vector<GivenAndFound> ring(double noise, double scale = 1.0, int mirrored = -1) {
  std::mt19937 random(3);
  std::normal_distribution<double> gauss;
  const RigidMotion world =
      Eigen::Translation3d(5, -3, 2) * Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 2) / 3.0);
  std::vector<GivenAndFound> views;
  for (int i = 0; i < 9; ++i) {
    const double angle = 0.6 * i;
    const Eigen::Vector3d eye(100 * std::cos(angle), 100 * std::sin(angle), 20 * (i % 4));
    GivenAndFound view;
    view.name = "v" + std::to_string(i);
    view.given = testing::look_at(eye, {1, 2, 3});
    view.found = view.given;
    view.found.translation() *= scale;
    if (mirrored >= 0) {
      Eigen::Vector3d sides = Eigen::Vector3d::Ones();
      sides[mirrored] = -1.0;
      // Any mirror of the world will do.
      view.found.linear() = sides.asDiagonal() * view.given.linear() * sides.asDiagonal();
      view.found.translation() = sides.cwiseProduct(view.given.translation());
    }
    view.found = world * view.found;
    view.found.translation() +=
        noise * Eigen::Vector3d(gauss(random), gauss(random), gauss(random));
    view.refined = view.from_origin = true;
    views.push_back(view);
  }
  return views;
}

TEST(GivenPoseNotes, TellTheScaleOfAllPlaces) {
  ASSERT_TRUE(common_scale(ring(0.2, 1.02)));
  EXPECT_NEAR(*common_scale(ring(0.2, 1.02)), 1.02, 0.002);
  EXPECT_NEAR(common_scale(ring(0.2, 0.97)).value_or(0.0), 0.97, 0.002);
  EXPECT_THAT(notes_on_given_poses(ring(0.2, 1.02)),
              Contains(AllOf(HasSubstr("times as far apart"), HasSubstr("too long"))));
  EXPECT_THAT(notes_on_given_poses(ring(0.2, 0.97)), Contains(HasSubstr("too short")));
}

TEST(GivenPoseNotes, TellNoScaleWherePlacesScatter) {
  for (const double noise : {0.0, 0.01, 1.0, 10.0})
    EXPECT_FALSE(common_scale(ring(noise))) << noise;
  EXPECT_FALSE(common_scale(ring(5.0, 1.02)));
  auto few = ring(0.0, 1.02);
  few.resize(3);
  EXPECT_FALSE(common_scale(few));
  auto elsewhere = ring(0.2, 1.02);  // The origins of views that stand for no sensor.
  for (auto& view : elsewhere) view.from_origin = false;
  EXPECT_FALSE(common_scale(elsewhere));
  auto one_place = ring(0.0);
  for (auto& view : one_place) view.given.translation() = view.found.translation().setZero();
  EXPECT_FALSE(common_scale(one_place));
}

TEST(GivenPoseNotes, OneWrongPoseHidesNothing) {
  auto views = ring(0.2, 1.02);
  views[4].given = Eigen::Translation3d(70, 0, 0) * views[4].given;
  EXPECT_NEAR(common_scale(views).value_or(0.0), 1.02, 0.003);
  views = ring(0.2, 1.0, 0);
  views[4].given = Eigen::Translation3d(70, 0, 0) * views[4].given;
  EXPECT_EQ(mirrored_axis(views), 0);
}

TEST(GivenPoseNotes, TellMirroredImages) {
  EXPECT_EQ(mirrored_axis(ring(0.2, 1.0, 0)), 0);
  EXPECT_EQ(mirrored_axis(ring(0.2, 1.0, 1)), 1);
  EXPECT_THAT(notes_on_given_poses(ring(0.2, 1.0, 0)), Contains(HasSubstr("left to right")));
  EXPECT_THAT(notes_on_given_poses(ring(0.2, 1.0, 1)), Contains(HasSubstr("top to bottom")));
  for (const double noise : {0.0, 0.2, 10.0}) EXPECT_FALSE(mirrored_axis(ring(noise))) << noise;
  EXPECT_THAT(notes_on_given_poses({}), IsEmpty());
}

}  // namespace
}  // namespace relief::registration
