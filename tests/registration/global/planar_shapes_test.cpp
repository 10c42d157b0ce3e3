// Views of shapes that fit in many ways: none may be placed at a pose that nothing tells from
// others.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/global/features/planar_view.h"
#include "registration/global/links/off_plane_samples.h"
#include "registration/global/pair_search.h"
#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/result_matchers.h"

namespace relief::registration {
namespace {

using testing::Surface;
using testing::SurfaceHit;
using DistanceFunction = double (*)(const Eigen::Vector3d&);

// A hemispherical shell, open at the top.
double bowl(const Eigen::Vector3d& p) { return std::max(std::abs(p.norm() - 40.0) - 3.0, p.z()); }

double cuboid(const Eigen::Vector3d& p, const Eigen::Vector3d& half_sides) {
  const Eigen::Vector3d outside = p.cwiseAbs() - half_sides;
  return outside.cwiseMax(0.0).norm() + std::min(outside.maxCoeff(), 0.0);
}
double box(const Eigen::Vector3d& p) { return cuboid(p, {34.0, 30.0, 26.0}); }
double cube(const Eigen::Vector3d& p) { return cuboid(p, {30.0, 30.0, 30.0}); }

Eigen::Vector3d gradient(DistanceFunction distance, const Eigen::Vector3d& p) {
  constexpr double kStep = 1e-4;
  Eigen::Vector3d result;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
    result[k] = distance(p + step) - distance(p - step);
  }
  return result.normalized();
}

// The surface where `distance`, which nowhere exceeds the true distance, is zero.
Surface surface_of(DistanceFunction distance) {
  return [distance](const Ray& ray) -> std::optional<SurfaceHit> {
    const Ray unit{ray.origin, ray.direction.normalized()};
    double t = 0.0;
    for (int i = 0; i < 200 && t < 500.0; ++i) {
      const double step = distance(unit.at(t));
      if (step < 1e-6) return SurfaceHit{t / ray.direction.norm(), gradient(distance, unit.at(t))};
      t += step;
    }
    return std::nullopt;
  };
}

std::vector<RangeView> views_without_poses(const Surface& surface, int count, double step,
                                           double height) {
  const Camera camera = Camera::pinhole(100, 100, {200, 200, 49.5, 49.5});
  std::vector<RangeView> views;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d eye(200 * std::cos(i * step), 200 * std::sin(i * step), height);
    views.push_back(testing::render(surface, camera, testing::look_at(eye, {0, 0, 0})));
    views.back().name = "v" + std::to_string(i);
    views.back().pose = PoseKind::kAbsent;
    views.back().world_from_view = RigidMotion::Identity();
    testing::add_range_noise(views.back(), 0.3, static_cast<std::uint32_t>(i + 1));
  }
  return views;
}

void expect_none_aligned_and_all_told_why(const std::vector<RangeView>& views) {
  const auto aligned = value_of(align_views(views));
  for (const auto& view : aligned.views) {
    EXPECT_FALSE(view.aligned) << view.name;
    EXPECT_THAT(view.reason, ::testing::AnyOf(::testing::HasSubstr("ambiguous"),
                                              ::testing::HasSubstr("no pose was found")));
  }
}

TEST(PlanarShapes, ABowlIsNotForced) {
  expect_none_aligned_and_all_told_why(views_without_poses(surface_of(bowl), 3, 0.7, 120.0));
}

TEST(PlanarShapes, UnrelatedObjectsAreNotForced) {
  auto views = views_without_poses(testing::bumpy_object(40.0), 1, 0.7, 50.0);
  for (const DistanceFunction other : {bowl, box}) {
    views.push_back(views_without_poses(surface_of(other), 1, 0.7, 90.0)[0]);
    views.back().name = "other" + std::to_string(views.size());
  }
  expect_none_aligned_and_all_told_why(views);
}

// Opposite sides of a box look alike and share nothing.
TEST(PlanarShapes, OppositeSidesOfABoxAreNotForced) {
  expect_none_aligned_and_all_told_why(views_without_poses(surface_of(box), 2, 3.14159, 20.0));
}

// All corners of a cube are alike: each view fits the others at several places, and itself.
TEST(PlanarShapes, NeighbouringSidesOfACubeAreNotForced) {
  expect_none_aligned_and_all_told_why(views_without_poses(surface_of(cube), 6, 0.7854, 140.0));
}

// They show different sides, which overlap by 88 % when they are taken for the same.
TEST(PlanarShapes, SidesOfACubeAQuarterTurnApartAreNotForced) {
  const auto views = views_without_poses(surface_of(cube), 6, 0.4, 60.0);
  expect_none_aligned_and_all_told_why({views[1], views[5]});
}

// Views that show other sides of much the same lengths.
TEST(PlanarShapes, NeighbouringSidesOfABoxAreNotForced) {
  expect_none_aligned_and_all_told_why(views_without_poses(surface_of(box), 3, 1.2, 140.0));
}

// A wall whose relief repeats every 60 along x.
double repeated_wall(const Eigen::Vector3d& p) {
  const double phase = 2.0 * std::numbers::pi * p.x() / 60.0;
  const double height = 4.0 * std::sin(phase + p.z() / 17.0) +
                        3.0 * std::sin(2.0 * phase - p.z() / 11.0 + 1.0) +
                        2.5 * std::sin(3.0 * phase + p.z() / 7.0 + 2.0);
  return 0.4 * (height - p.y());  // It rises by 1.8 at most.
}

// Each shows 100 of it, from almost the same place.
std::vector<RangeView> views_of_the_repeated_wall() {
  const Camera camera = Camera::pinhole(100, 100, {200, 200, 49.5, 49.5});
  std::vector<RangeView> views;
  for (const auto& [x, z] : {std::pair(0.0, 0.0), std::pair(2.0, 5.0), std::pair(-1.0, 9.0)}) {
    views.push_back(testing::render(surface_of(repeated_wall), camera,
                                    testing::look_at({x + 8.0, -200.0, z}, {x, 0.0, z})));
    views.back().pose = PoseKind::kAbsent;
    testing::add_range_noise(views.back(), 0.3, static_cast<std::uint32_t>(views.size()));
  }
  return views;
}

CoarseScale scale_of(const ViewSurface& surface) {
  return {surface.radius(), 3.0 * surface.spacing()};
}

TEST(RepeatedShape, FitsItselfAndOthersAtTheSecondPlace) {
  const auto views = views_of_the_repeated_wall();
  const ViewSurface a(views[0]), b(views[1]);
  const CoarseScale scale = scale_of(a);
  VerificationThresholds limits;
  limits.min_overlap = 0.3;
  const auto motions =
      partial_symmetries(prepare_coarse_view(a, scale), scale, limits, {.seeds = 150});
  const auto shift = [&](double by) {
    const RigidMotion along(Eigen::Translation3d(by, 0.0, 0.0));
    return RigidMotion(views[0].world_from_view.inverse() * along * views[0].world_from_view);
  };
  const auto is_at = [&](const RigidMotion& place) {
    return ::testing::Truly([&, place](const RigidMotion& motion) {
      return same_pose(a, motion, place, 2.0 * scale.cell);
    });
  };
  EXPECT_THAT(motions, ::testing::UnorderedElementsAre(is_at(shift(60.0)), is_at(shift(-60.0))));

  const RigidMotion truth = views[1].world_from_view.inverse() * views[0].world_from_view;
  const auto others = alternative_poses(a, b, truth, motions, {}, scale);
  ASSERT_EQ(others.size(), 2u);
  for (const PoseHypothesis& other : others) {
    EXPECT_FALSE(same_pose(a, other.b_from_a, truth, 20.0));
    EXPECT_TRUE(same_pose(a, other.b_from_a, truth * shift(60.0), 2.0 * scale.cell) ||
                same_pose(a, other.b_from_a, truth * shift(-60.0), 2.0 * scale.cell));
  }
}

// At the right poses the views share almost all of what they see, at the others less than half.
TEST(RepeatedShape, IsAlignedWhereOtherPosesExplainLess) {
  const auto truth = views_of_the_repeated_wall();
  auto views = truth;
  for (RangeView& view : views) view.world_from_view = RigidMotion::Identity();
  const auto aligned = value_of(align_views(views));
  ASSERT_TRUE(aligned.complete());
  for (std::size_t i = 1; i < views.size(); ++i) {
    const RigidMotion found =
        aligned.views[i].world_from_view.inverse() * aligned.views[0].world_from_view;
    const RigidMotion expected = truth[i].world_from_view.inverse() * truth[0].world_from_view;
    EXPECT_TRUE(same_pose(ViewSurface(views[0]), found, expected, 0.5)) << i;
  }
}

TEST(PlanarView, KnowsFlatFaces) {
  const auto view_of = [](const Surface& surface) {
    return views_without_poses(surface, 1, 0.0, 140.0)[0];
  };
  const RangeView corner = view_of(surface_of(box)), inside = view_of(surface_of(bowl)),
                  bumpy = view_of(testing::bumpy_object(40.0));
  EXPECT_TRUE(is_mostly_planar(find_flat_faces(ViewSurface(corner))));
  EXPECT_FALSE(is_mostly_planar(find_flat_faces(ViewSurface(inside))));
  EXPECT_FALSE(is_mostly_planar(find_flat_faces(ViewSurface(bumpy))));
  EXPECT_LT(find_flat_faces(ViewSurface(corner), 1).fraction, 0.8);
  EXPECT_GT(find_flat_faces(ViewSurface(corner), 2).fraction,
            0.95);  // The eye is level with one side.
}

// A square room from within, and the same with a ball and two posts on its floor.
double room(const Eigen::Vector3d& p) { return -cuboid(p, {100.0, 100.0, 60.0}); }
double furnished_room(const Eigen::Vector3d& p) {
  const double ball = (p - Eigen::Vector3d(40, 10, -48)).norm() - 12.0;
  const double post = cuboid(p - Eigen::Vector3d(62, 58, -45), {5.0, 7.0, 15.0});
  const double bench = cuboid(p - Eigen::Vector3d(10, 66, -53), {16.0, 5.0, 7.0});
  return std::min({room(p), ball, post, bench});
}

std::vector<RangeView> views_of_room(DistanceFunction distance) {
  const Camera camera = Camera::pinhole(320, 240, {220, 220, 159.5, 119.5});
  std::vector<RangeView> views;
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(-70, -60, 10), Eigen::Vector3d(-80, -10, 25)})
    views.push_back(testing::render(surface_of(distance), camera,
                                    testing::look_at(eye, Eigen::Vector3d(50, 45, -30))));
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].name = "v" + std::to_string(i);
    testing::add_range_noise(views[i], 0.1, static_cast<std::uint32_t>(i + 1));
  }
  return views;
}

bool confirmed_at(const std::vector<RangeView>& views, const RigidMotion& second_from_first) {
  const ViewSurface a(views[0]), b(views[1]);
  const FlatFaces a_faces = find_flat_faces(a), b_faces = find_flat_faces(b);
  EXPECT_TRUE(is_mostly_planar(a_faces) && is_mostly_planar(b_faces));
  return judge_off_plane_samples(a, a_faces, b, b_faces, second_from_first) ==
         OffPlaneVerdict::kConfirmed;
}

TEST(OffPlaneSamples, ConfirmARightPoseAlone) {
  const auto views = views_of_room(furnished_room);
  const RigidMotion truth = views[1].world_from_view.inverse() * views[0].world_from_view;
  EXPECT_TRUE(confirmed_at(views, truth));
  EXPECT_FALSE(confirmed_at(views_of_room(room), truth)) << "nothing stands clear of the walls";
  for (const double turn : {0.5, 1.0, 1.5}) {  // The walls meet walls again.
    const Eigen::AngleAxisd about_z(turn * std::numbers::pi, Eigen::Vector3d::UnitZ());
    EXPECT_FALSE(confirmed_at(
        views, views[1].world_from_view.inverse() * about_z * views[0].world_from_view));
  }
  for (const double shift : {-15.0, 15.0})  // Along a wall, which fits still.
    EXPECT_FALSE(
        confirmed_at(views, views[1].world_from_view.inverse() * Eigen::Translation3d(shift, 0, 0) *
                                views[0].world_from_view));
}

TEST(OffPlaneSamples, LetARoomBeAlignedByItsFurniture) {
  const auto truth = views_of_room(furnished_room);
  const auto aligned = value_of(align_views(testing::without_poses(truth)));
  ASSERT_TRUE(aligned.complete()) << aligned.views[1].reason;
  const RigidMotion found =
      aligned.views[1].world_from_view.inverse() * aligned.views[0].world_from_view;
  const RigidMotion expected = truth[1].world_from_view.inverse() * truth[0].world_from_view;
  EXPECT_TRUE(same_pose(ViewSurface(truth[0]), found, expected, 0.5));
}

TEST(PlanarView, HasNoFacesWithoutSamples) {
  const RangeView view = testing::render([](const Ray&) { return std::nullopt; },
                                         Camera::pinhole(20, 20, {200, 200, 9.5, 9.5}));
  EXPECT_EQ(find_flat_faces(ViewSurface(view), 4).fraction, 0.0);
  EXPECT_FALSE(is_mostly_planar(find_flat_faces(ViewSurface(view))));
}

}  // namespace
}  // namespace relief::registration
