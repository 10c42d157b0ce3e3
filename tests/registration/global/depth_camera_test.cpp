#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/result_matchers.h"

namespace relief::registration {
namespace {

testing::Surface nearest_of(std::vector<testing::Surface> parts) {
  return [parts = std::move(parts)](const Ray& ray) {
    std::optional<testing::SurfaceHit> nearest;
    for (const auto& part : parts)
      if (const auto hit = part(ray); hit && hit->t > 0.0 && (!nearest || hit->t < nearest->t))
        nearest = hit;
    return nearest;
  };
}

// A floor with things on it before a wall, and another wall far behind [mm, y down].
testing::Surface room() {
  std::vector<testing::Surface> parts = {
      testing::plane({0, 600, 0}, {0, -1, 0}),
      testing::plane({0, 0, 25000}, {0, 0, -1}),
  };
  const double places[][4] = {{-700, 1500, 250, 480}, {150, 1900, 180, 500},
                              {800, 2300, 300, 450},  {-250, 2700, 320, 400},
                              {1500, 2000, 220, 520}, {2100, 2900, 400, 380},
                              {1300, 3200, 260, 470}, {-1200, 2400, 350, 350}};
  for (const auto& [x, z, radius, y] : places)
    parts.push_back(testing::sphere({x, y, z}, 1.4 * radius));
  return nearest_of(parts);
}

// Three balls on the floor, turned about a vertical axis.
testing::Surface figure(double angle) {
  std::vector<testing::Surface> balls;
  const double places[][4] = {{0, 0, 150, 450}, {260, 90, 150, 450}, {-120, -240, 130, 470}};
  for (const auto& [x, z, radius, y] : places)
    balls.push_back(testing::sphere({-150 + x * std::cos(angle) - z * std::sin(angle), y,
                                     1250 + x * std::sin(angle) + z * std::cos(angle)},
                                    radius));
  return nearest_of(balls);
}

// Active stereo: inverse ranges are rounded, to 1 mm at 0.7 m and to 1.3 m at the far wall, and err
// smoothly by a part of the range.
void add_stereo_errors(RangeView& view, double phase) {
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      double& range = view.range(u, v);
      const double metric = view.camera.ray(u, v).direction.norm();
      const double smooth = std::sin(u / 5.0 + phase) * std::cos(v / 6.0 + 2.0 * phase);
      const double inverse = (1.0 + 0.001 * smooth) / (range * metric);
      range = 1.0 / (std::round(inverse / 2e-6) * 2e-6) / metric;
    }
  }
}

// A robot that drives and turns, and looks down: an eighth of each view is the far wall.
std::vector<RangeView> views_of_robot() {
  const Camera camera = Camera::pinhole(200, 150, {120, 120, 99.5, 74.5});
  std::vector<RangeView> views;
  for (int i = 0; i < 6; ++i) {
    const RigidMotion pose = Eigen::Translation3d(20.0 * i, 0, 110.0 * i) *
                             Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(-0.44, Eigen::Vector3d::UnitX());
    views.push_back(testing::render(room(), camera, pose));
    views.back().name = "view" + std::to_string(i);
    add_stereo_errors(views.back(), 1.7 * i);
  }
  return views;
}

// A camera that stands still sees a room, and a figure that is turned between views.
std::vector<RangeView> views_of_turned_figure(double step) {
  const Camera camera = Camera::pinhole(200, 150, {120, 120, 99.5, 74.5});
  const RigidMotion pose(Eigen::AngleAxisd(-0.44, Eigen::Vector3d::UnitX()));
  std::vector<RangeView> views;
  for (int i = 0; i < 4; ++i) {
    views.push_back(testing::render(nearest_of({room(), figure(step * i)}), camera, pose));
    views.back().name = "view" + std::to_string(i);
    views.back().pose = PoseKind::kAbsent;
    testing::add_range_noise(views.back(), 0.5, static_cast<std::uint32_t>(i + 1));
  }
  return views;
}

void expect_no_wrong_pose(const std::vector<RangeView>& truth, const Alignment& alignment,
                          std::size_t at_least) {
  std::vector<RangeView> placed;
  std::vector<RigidMotion> estimate;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!alignment.views[i].aligned) continue;
    placed.push_back(truth[i]);
    estimate.push_back(alignment.views[i].world_from_view);
  }
  EXPECT_GE(placed.size(), at_least);
  for (const double error :
       testing::mean_displacements(placed, estimate, testing::poses_of(placed)))
    EXPECT_LT(error, 60.0);
}

// From poses that are all the same.
void expect_all_found(PoseKind pose) {
  const auto truth = views_of_robot();
  auto views = truth;
  for (RangeView& view : views) {
    view.pose = pose;
    view.world_from_view = RigidMotion::Identity();
  }
  expect_no_wrong_pose(truth, value_of(align_views(views)), 6);
}

TEST(DepthCamera, ViewsOfARoomFindEachOtherAndFarWallsHideNoErrors) {
  expect_all_found(PoseKind::kAbsent);
}

// All share the floor, on which they slide.
TEST(DepthCamera, GuessesThatAreAllTheSameAreNotKeptForACommonFloor) {
  expect_all_found(PoseKind::kGuess);
}

// The pairs of the others tell what errors to expect of the view that is sought.
TEST(DepthCamera, AViewWithoutAPoseIsFoundAmongViewsThatHaveOne) {
  const auto truth = views_of_robot();
  for (const std::size_t missing : {0u, 3u, 5u}) {
    auto views = truth;
    for (RangeView& view : views) view.pose = PoseKind::kGuess;
    views[missing].pose = PoseKind::kAbsent;
    views[missing].world_from_view = RigidMotion::Identity();
    expect_no_wrong_pose(truth, value_of(align_views(views)), 6);
  }
}

TEST(DepthCamera, WhatStandsStillJoinsNoViewsOfAnObjectThatWasTurned) {
  const auto alignment = value_of(align_views(views_of_turned_figure(1.0)));
  for (const auto& view : alignment.views) {
    EXPECT_FALSE(view.aligned) << view.name;
    EXPECT_THAT(view.reason, ::testing::HasSubstr("taken from one place while something moved"));
  }
}

TEST(DepthCamera, ViewsFromOnePlaceAreJoinedWhereNothingMoved) {
  expect_no_wrong_pose(views_of_turned_figure(0.0),
                       value_of(align_views(views_of_turned_figure(0.0))), 4);
}

}  // namespace
}  // namespace relief::registration
