// Given poses along motions that no relief of the views tells anything about.
#include "registration/posegraph/joint/degenerate_groups.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/registration/relief_views.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::registration {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kDistance = 500.0, kRadius = 60.0;  // The samples are one unit apart.

// A view of a surface about the y axis at its true pose, from `angle` about the axis, with noise
// that neighbours share: it tilts normals as relief does.
RangeView view_of(const testing::Surface& surface, double angle, double height,
                  double target_height, double noise, std::uint32_t seed) {
  const Eigen::Vector3d eye(kDistance * std::sin(angle), height, -kDistance * std::cos(angle));
  RangeView view = testing::render(
      surface, Camera::pinhole(160, 160, {kDistance, kDistance, 79.5, 79.5}),
      testing::look_at(eye, Eigen::Vector3d(0, target_height, 0), Eigen::Vector3d::UnitY()));
  view.name = "view" + std::to_string(seed);
  testing::add_smooth_noise(view, noise, 3, seed);
  return view;
}

std::vector<RangeView> views_of_cylinder(bool normal_maps) {
  std::vector<RangeView> views;
  for (std::uint32_t i = 0; i < 5; ++i) {
    const double height = i % 2 == 0 ? 20.0 : -20.0;
    views.push_back(
        view_of(testing::cylinder(kRadius), 0.25 * i, height, 0.5 * height, 0.3, 10 + i));
    if (!normal_maps) views.back().normals = {};
  }
  return views;
}

// How far the view is from its true place along the cylinder's axis, round it, and away from it.
struct Error {
  double along = 0.0, round = 0.0, away = 0.0;
};

Error error_of(const RangeView& view, const RigidMotion& found) {
  const Eigen::Vector3d front = view.world_from_view * Eigen::Vector3d(0, 0, kDistance - kRadius);
  const Eigen::Vector3d moved = found * view.world_from_view.inverse() * front - front;
  const Eigen::Vector3d out = Eigen::Vector3d(front.x(), 0, front.z()).normalized();
  return {std::abs(moved.y()), std::abs(moved.dot(out.cross(Eigen::Vector3d::UnitY()))),
          std::abs(moved.dot(out))};
}

// Moves each view along its own way out, to and fro, by what the surface tells.
void move_outward(std::vector<RangeView>& views) {
  for (std::size_t i = 1; i < views.size(); ++i) {
    const Eigen::Vector3d out =
        (views[i].world_from_view.translation().cwiseProduct(Eigen::Vector3d(1, 0, 1)))
            .normalized();
    views[i].world_from_view.pretranslate((i % 2 == 0 ? 1.5 : -1.5) * out);
  }
}

class DegenerateViews : public ::testing::TestWithParam<bool> {};

TEST_P(DegenerateViews, KeepGivenPosesAlongWhatOnlyNoiseHolds) {
  const auto truth = views_of_cylinder(GetParam());
  auto views = truth;
  move_outward(views);
  const auto aligned = value_of(align_views(views));
  EXPECT_TRUE(aligned.complete());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Error error = error_of(truth[i], aligned.views[i].world_from_view);
    EXPECT_LT(error.along, 0.1) << i;
    EXPECT_LT(error.round, 0.1) << i;
    EXPECT_LT(error.away, 0.1) << i;
    EXPECT_EQ(aligned.views[i].kept_motions.size(), i == 0 ? 0u : 2u) << i;
    if (i == 0) continue;
    EXPECT_EQ(aligned.views[i].status, PoseStatus::kUnverified);
    EXPECT_THAT(aligned.views[i].reason, HasSubstr("guesses were off by 1.5 (median)"));
  }
  EXPECT_THAT(aligned.notes, Contains(HasSubstr("kept where alignment started")));
  for (const PairFit& pair : aligned.pairs) EXPECT_EQ(pair.status, PairStatus::kDegenerate);
  // What nothing tells of is known no better than that the view lies near the others.
  const Matrix6d& covariance = aligned.views[2].pose_covariance;
  const Eigen::Vector3d eye = truth[2].world_from_view.translation();
  const Eigen::Vector3d out = Eigen::Vector3d(eye.x(), 0, eye.z()).normalized();
  EXPECT_GT(std::sqrt(covariance(4, 4)), 0.3 * kRadius);
  EXPECT_LT(std::sqrt(out.dot(covariance.bottomRightCorner<3, 3>() * out)), 0.1);
}

INSTANTIATE_TEST_SUITE_P(NormalMaps, DegenerateViews, ::testing::Bool(), [](const auto& parameter) {
  return parameter.param ? "With" : "Without";
});

// Where a ray first meets the cylinder, or a bump on it: there are many at either end, and none
// between.
testing::Surface cylinder_with_bumps() {
  std::vector<testing::Surface> parts = {testing::cylinder(kRadius)};
  for (int i = 0; i < 24; ++i) {
    const double angle = -0.5 + 0.4 * (i % 6), out = kRadius - 6.0,
                 height = (i < 12 ? -1 : 1) * (i % 12 < 6 ? 55.0 : 88.0) + 5.0 * (i % 3);
    parts.push_back(testing::sphere({out * std::sin(angle), height, -out * std::cos(angle)}, 16.0));
  }
  return [parts](const Ray& ray) {
    std::optional<testing::SurfaceHit> first;
    for (const auto& part : parts)
      if (const auto hit = part(ray); hit && (!first || hit->t < first->t)) first = hit;
    return first;
  };
}

// Along the motions that views keep guesses are as good as elsewhere.
TEST(DegenerateViews, AreVerifiedWhereGuessesAreRight) {
  const auto aligned = value_of(align_views(views_of_cylinder(false)));
  for (const ViewReport& view : aligned.views) EXPECT_EQ(view.status, PoseStatus::kVerified);
  EXPECT_FALSE(aligned.views[1].kept_motions.empty());
}

// The bumps hold the views of either end to each other, and nothing holds the ends along the
// cylinder, where the four of the second end drift by 9 units together. No view alone does.
TEST(DegenerateGroups, KeepTheirMeanAlongWhatOnlyNoiseHolds) {
  std::vector<RangeView> truth;
  for (std::uint32_t i = 0; i < 8; ++i) {
    const double height = i < 4 ? -50.0 : 50.0;
    truth.push_back(view_of(cylinder_with_bumps(), 0.25 * (i % 4), height, height, 0.6, 30 + i));
    truth.back().normals = {};
  }
  auto views = truth;
  move_outward(views);
  for (std::size_t i = 1; i < views.size(); ++i)  // Of the second end, by nothing on average.
    views[i].world_from_view.pretranslate(Eigen::Vector3d(0, i % 2 == 0 ? 0.8 : -0.8, 0));
  const auto aligned = value_of(align_views(views));
  EXPECT_TRUE(aligned.complete());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Error error = error_of(truth[i], aligned.views[i].world_from_view);
    EXPECT_LT(error.along, 0.4) << i;
    EXPECT_LT(error.round, 0.4) << i;
    EXPECT_LT(error.away, 0.4) << i;
    EXPECT_EQ(aligned.views[i].kept_motions.empty(), i < 4) << i;
  }
  EXPECT_THAT(aligned.notes, Contains(HasSubstr("kept where alignment started")));
}

// Of two surfaces of a plane whose normals err apart from each other, and a wall that both show.
SharedConstraintSum plane_and_wall(double wall_share) {
  SharedConstraintSum sum(Eigen::Vector3d(1, 2, 3), 5.0);
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d point(0.1 * (i % 20), 0.1 * (i / 20), 0.0);
    const double tilt = i % 2 == 0 ? 0.1 : -0.1;
    const bool wall = i < 400 * wall_share;
    const Eigen::Vector3d normal = wall ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d(0, 0, 1);
    const Eigen::Vector3d error(tilt, 0, 0), other(i % 4 < 2 ? 0.1 : -0.1, 0, 0);
    sum.add({point, wall ? normal : normal + error}, wall ? normal : normal + other);
  }
  return sum;
}

TEST(DegenerateGroups, AreHeldAlongMotionsByWhatBothSidesShow) {
  DegenerateDirection along_x, about_z;
  along_x.motion << 0, 0, 0, 2, 0, 0;
  const MotionConstraint noise = plane_and_wall(0.0).along(along_x);
  EXPECT_NEAR(noise.own, 400 * 4.0 * 0.01, 1e-9);
  EXPECT_NEAR(noise.shared, 0.0, 1e-9);
  EXPECT_NEAR(noise.correlation(), 0.0, 1e-9);
  const MotionConstraint wall = plane_and_wall(0.1).along(along_x);
  EXPECT_NEAR(wall.shared, 40 * 4.0, 1e-9);
  EXPECT_NEAR(wall.own, 40 * 4.0 + 360 * 4.0 * 0.01, 1e-9);
  // Turning about an axis through the plane moves a point of the wall along its normal by its y.
  about_z.motion << 0, 0, 1, 0, 0, 0;
  double squares = 0.0;
  for (int i = 0; i < 40; ++i) squares += std::pow(0.1 * (i / 20), 2);
  EXPECT_NEAR(plane_and_wall(0.1).along(about_z).shared, squares, 1e-9);

  // Pairs within a group hold nothing of it, nor do pairs of others.
  const std::vector<PairConstraint> pairs = {
      {0, 1, plane_and_wall(0.1)}, {1, 2, plane_and_wall(0.1)}, {0, 3, plane_and_wall(0.1)}};
  EXPECT_NEAR(constraint_along_motions({{{1, 2}, {along_x}}}, pairs).shared, wall.shared, 1e-9);
  EXPECT_NEAR(constraint_along_motions({{{2}, {along_x}}, {{3}, {along_x}}}, pairs).own,
              2.0 * wall.own, 1e-9);
}

// A view that drifts alone does not displace those that hold still with it.
TEST(DegenerateGroups, WithinOthersGoBackAlone) {
  const auto ring = testing::ring_of_views({.views = 5, .pixels = 40});
  std::vector<ViewSurface> surfaces;
  for (const auto& view : ring) surfaces.emplace_back(view);
  DegenerateDirection along_y, along_x;
  along_y.motion << 0, 0, 0, 0, 1, 0;
  along_x.motion << 0, 0, 0, 1, 0, 0;
  const std::vector<DegenerateGroup> groups = {{{1}, {along_y}},
                                               {{1, 2, 3, 4}, {along_y, along_x}}};
  const auto start = testing::poses_of(ring);
  auto poses = start;
  poses[1].pretranslate(Eigen::Vector3d(0, 4, 0));
  const auto kept = remove_drift(groups, Drift::kAlongMotions, surfaces, start, poses);
  for (std::size_t i = 0; i < poses.size(); ++i)
    EXPECT_LT((poses[i].translation() - start[i].translation()).norm(), 1e-9) << i;
  EXPECT_EQ(kept[0].size(), 0u);
  EXPECT_EQ(kept[1].size(), 2u);
  EXPECT_EQ(kept[4].size(), 2u);
  // What a group moves by as one goes back as well, and nothing else does.
  for (std::size_t i = 1; i < poses.size(); ++i)
    poses[i] = Eigen::Translation3d(3, -2, 7 + 0.1 * static_cast<double>(i % 2)) * start[i];
  remove_drift(groups, Drift::kAlongMotions, surfaces, start, poses);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Vector3d left = poses[i].translation() - start[i].translation();
    EXPECT_LT(left.head<2>().norm(), 1e-9) << i;
    EXPECT_NEAR(left.z(), 7 + 0.1 * static_cast<double>(i % 2), 1e-9) << i;
  }
  remove_drift(groups, Drift::kAll, surfaces, start, poses);
  for (std::size_t i = 1; i < poses.size(); ++i)
    EXPECT_LT((poses[i].translation() - start[i].translation()).norm(), 0.1) << i;
}

TEST(ViewsOfAnObject, KeepNoMotion) {
  const auto aligned = value_of(align_views(testing::perturbed(
      testing::ring_of_views({.noise = 1.0}), Eigen::Vector3d::Zero(), 0.03, 1.0)));
  EXPECT_TRUE(aligned.complete());
  for (const auto& view : aligned.views) EXPECT_TRUE(view.kept_motions.empty()) << view.name;
}

}  // namespace
}  // namespace relief::registration
