#include "registration/given_poses/given_pose_notes.h"

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/given_poses/common_pose_shift.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::registration {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

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

TEST(GivenPoseNotes, TellViewsThatChangedPlaces) {
  for (const double noise : {0.0, 0.2, 2.0}) {
    auto views = ring(noise);
    EXPECT_THAT(exchanged_views(views), IsEmpty());
    std::swap(views[3].given, views[7].given);
    EXPECT_THAT(exchanged_views(views), ElementsAre(std::pair(3, 7))) << noise;
    EXPECT_THAT(notes_on_given_poses(views),
                Contains(HasSubstr("views v3 and v7 seem to have changed places")));
    std::swap(views[0].given, views[5].given);  // The first view may be one of them.
    EXPECT_THAT(exchanged_views(views), ElementsAre(std::pair(0, 5), std::pair(3, 7))) << noise;
  }
  auto one_moved = ring(0.2);
  one_moved[3].given = one_moved[7].given;
  EXPECT_THAT(exchanged_views(one_moved), IsEmpty());
}

// The poses of opposite views are each other's in a mirror.
TEST(GivenPoseNotes, TellNoChangeOfPlacesWhereMostViewsAreElsewhere) {
  for (const int axis : {0, 1}) EXPECT_THAT(exchanged_views(ring(0.2, 1.0, axis)), IsEmpty());
  EXPECT_THAT(exchanged_views(ring(30.0)), IsEmpty());
}

TEST(GivenPoseNotes, TellMirroredImages) {
  EXPECT_EQ(mirrored_axis(ring(0.2, 1.0, 0)), 0);
  EXPECT_EQ(mirrored_axis(ring(0.2, 1.0, 1)), 1);
  EXPECT_THAT(notes_on_given_poses(ring(0.2, 1.0, 0)), Contains(HasSubstr("left to right")));
  EXPECT_THAT(notes_on_given_poses(ring(0.2, 1.0, 1)), Contains(HasSubstr("top to bottom")));
  for (const double noise : {0.0, 0.2, 10.0}) EXPECT_FALSE(mirrored_axis(ring(noise))) << noise;
  EXPECT_THAT(notes_on_given_poses({}), IsEmpty());
}

// Half a turn is the same in a mirror, and so are the poses of opposite views.
TEST(GivenPoseNotes, TellMirroredImagesOfAFullTurn) {
  std::vector<GivenAndFound> views(8);
  const Eigen::DiagonalMatrix<double, 3> mirror(-1.0, 1.0, 1.0);
  for (int i = 0; i < 8; ++i) {
    const double angle = 0.25 * std::numbers::pi * i;
    GivenAndFound& view = views[static_cast<std::size_t>(i)];
    view.given = testing::look_at({100 * std::cos(angle), 100 * std::sin(angle), 30}, {0, 0, 0});
    view.found.linear() = mirror * view.given.linear() * mirror;
    view.found.translation() = mirror * view.given.translation();
  }
  EXPECT_EQ(mirrored_axis(views), 0);
}

// The ring, found in the world of its poses but shifted in the frame of each view.
std::vector<GivenAndFound> shifted_ring(const Eigen::Vector3d& shift, double noise) {
  std::vector<GivenAndFound> views = ring(0.0);
  std::mt19937 random(4);
  std::normal_distribution<double> gauss;
  for (GivenAndFound& view : views) {
    view.centre = Eigen::Vector3d(5.0 * gauss(random), 5.0 * gauss(random), 100.0);
    view.focal_lengths = Eigen::Vector2d(500.0, 500.0);
    view.found = view.given * Eigen::Translation3d(shift);
    view.found.translation() +=
        noise * Eigen::Vector3d(gauss(random), gauss(random), gauss(random));
  }
  return views;
}

TEST(GivenPoseNotes, TellPrincipalPointsThatAreOff) {
  const Eigen::Vector3d shift(0.2, -2.4, 0.05);  // -1 and 12 pixels of principal points.
  auto views = shifted_ring(shift, 0.05);
  ASSERT_TRUE(common_shift(views));
  EXPECT_LT((*common_shift(views) - shift).norm(), 0.15);
  EXPECT_THAT(notes_on_given_poses(views),
              Contains(AllOf(HasSubstr("cx, cy"), HasSubstr("cropped"), HasSubstr(", 12."))));
  views[4].found = Eigen::Translation3d(30, 0, 0) * views[4].found;
  EXPECT_LT((common_shift(views).value_or(Eigen::Vector3d::Zero()) - shift).norm(), 0.15);
}

// Along the axis of a turntable a shift of all views is a shift of the world.
TEST(GivenPoseNotes, TellNoShiftThatTheWorldMayHaveMadeAlone) {
  const Eigen::Vector3d shift(2.0, 0.0, 0.0);
  auto views = shifted_ring(shift, 0.0);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double angle = 0.6 * static_cast<double>(i);
    views[i].given =
        testing::look_at({100 * std::cos(angle), 100 * std::sin(angle), 30}, {0, 0, 0});
    views[i].found = Eigen::Translation3d(0, 0, 5) * views[i].given * Eigen::Translation3d(shift);
  }
  ASSERT_TRUE(common_shift(views));
  EXPECT_LT((*common_shift(views) - shift).norm(), 0.1);
}

// Seen from above, the axis of a turntable leans towards the views. The part of the shift along it
// is the world's, and what is left of the shift has a z and looks like a scale.
TEST(GivenPoseNotes, TellPrincipalPointsOfATurntableSeenFromAbove) {
  double unit = 1.0;
  const auto turntable = [&](const Eigen::Vector3d& shift, double scale) {
    auto views = shifted_ring(shift, 0.0);
    std::mt19937 random(5);
    std::normal_distribution<double> gauss(0.0, 0.01);
    for (std::size_t i = 0; i < views.size(); ++i) {
      const double angle = 0.6 * static_cast<double>(i);
      views[i].given =
          testing::look_at({100 * std::cos(angle), 100 * std::sin(angle), 40}, {0, 0, 0});
      views[i].found = Eigen::Translation3d(0, 0, 2.0 * shift.norm()) * views[i].given *
                       Eigen::Translation3d(shift);
      views[i].found.translation() *= scale;
      views[i].found.translation() += Eigen::Vector3d(gauss(random), gauss(random), gauss(random));
      for (RigidMotion* pose : {&views[i].given, &views[i].found}) pose->translation() *= unit;
      views[i].centre *= unit;
    }
    return views;
  };
  const Eigen::Vector3d shift(1.6, -2.4, 0.0);
  const auto views = turntable(shift, 1.0);
  EXPECT_LT((common_shift(views).value_or(Eigen::Vector3d::Zero()) - shift).norm(), 0.15);
  EXPECT_THAT(notes_on_given_poses(views), Contains(HasSubstr("(-8.0, 12.")));
  EXPECT_THAT(notes_on_given_poses(views), Not(Contains(HasSubstr("times as far apart"))));
  for (const double other : {1.0, 1e-4}) {
    unit = other;
    EXPECT_TRUE(shift_explains_more_than_scale(turntable(shift, 1.0)));
    const auto longer = notes_on_given_poses(turntable({0, 0, 0}, 1.02));
    EXPECT_THAT(longer, Contains(HasSubstr("times as far apart")));
    EXPECT_THAT(longer, Not(Contains(HasSubstr("cx, cy"))));
  }
}

TEST(GivenPoseNotes, TellNoPrincipalPointWhereMovesScatterOrGoForward) {
  EXPECT_FALSE(common_shift(shifted_ring({0, 0, 0}, 0.05)));
  EXPECT_FALSE(common_shift(shifted_ring({0.5, 0, 0}, 0.5)));
  const auto forward = Contains(HasSubstr("cx, cy"));
  EXPECT_THAT(notes_on_given_poses(shifted_ring({0.1, 0, 2}, 0.05)), Not(forward));
  EXPECT_THAT(notes_on_given_poses(shifted_ring({0.05, 0.05, 0}, 0.001)), Not(forward));
  EXPECT_THAT(notes_on_given_poses(ring(0.2, 1.02)), Not(forward));
}

}  // namespace
}  // namespace relief::registration
