#include "relief/scan/static_background.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

using testing::kDegree;
using testing::look_at;
using testing::plane;
using testing::render;
using testing::sphere;
using testing::Surface;

const Camera kCamera = Camera::pinhole(160, 120, {200, 200, 79.5, 59.5});
constexpr double kNoise = 0.1;  // About a third of the sample spacing.

Surface nearest_of(std::vector<Surface> parts) {
  return [=](const Ray& ray) {
    std::optional<testing::SurfaceHit> nearest;
    for (const Surface& part : parts) {
      const auto hit = part(ray);
      if (hit && hit->t > 0.0 && (!nearest || hit->t < nearest->t)) nearest = hit;
    }
    return nearest;
  };
}

// A vertical cylinder round the z axis between two heights.
Surface cylinder(double radius, double low, double high) {
  return [=](const Ray& ray) -> std::optional<testing::SurfaceHit> {
    const Eigen::Vector2d o = ray.origin.head<2>(), d = ray.direction.head<2>();
    const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - radius * radius;
    const double discriminant = b * b - a * c;
    if (discriminant < 0.0) return std::nullopt;
    const double t = (-b - std::sqrt(discriminant)) / a;
    const Eigen::Vector3d point = ray.at(t);
    if (point.z() < low || point.z() > high) return std::nullopt;
    return testing::SurfaceHit{t, {point.x() / radius, point.y() / radius, 0.0}};
  };
}

// Three spheres of different size: no symmetry.
Surface figure() {
  return nearest_of({sphere({4, 0, 2}, 9), sphere({-6, 5, -5}, 6), sphere({-2, -9, 6}, 5)});
}

struct Scans {
  std::vector<RangeView> views;
  std::vector<Grid<std::uint8_t>> truth;  // 1: background.
};

// Adds a view of `object`; `standing`, if any, is fixed in the camera's frame.
void see(const Surface& object, const std::optional<Surface>& standing, const RigidMotion& pose,
         Scans& scans) {
  RangeView view = render(object, kCamera, pose);
  Grid<std::uint8_t> background(view.width(), view.height(), 0);
  if (standing) {
    const RangeView plate = render(*standing, kCamera);
    for (std::size_t k = 0; k < view.range.size(); ++k) {
      if (!(plate.range[k] > 0.0) || plate.range[k] >= view.range[k]) continue;
      view.range[k] = plate.range[k];
      view.normals[k] = plate.normals[k];
      background[k] = 1;
    }
  }
  const std::size_t i = scans.views.size();
  testing::add_range_noise(view, kNoise, static_cast<std::uint32_t>(i + 1));
  view.name = "v" + std::to_string(i);
  scans.views.push_back(std::move(view));
  scans.truth.push_back(std::move(background));
}

// `object` turned before a camera; `behind`, if any, is fixed in the camera's frame.
Scans turn(const Surface& object, const std::optional<Surface>& behind, int count = 12,
           double height = 15.0) {
  Scans scans;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / count;
    const RigidMotion pose =
        look_at({80 * std::cos(angle), 80 * std::sin(angle), height}, {0, 0, 0});
    see(object, behind, pose, scans);
  }
  return scans;
}

// As poses are that were found by eye.
void disturb_poses(std::vector<RangeView>& views) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double phase = static_cast<double>(i);
    const Eigen::Vector3d axis(std::cos(2.3 * phase), std::sin(1.7 * phase), std::cos(phase));
    views[i].world_from_view = Eigen::Translation3d(0.5 * axis) *
                               Eigen::AngleAxisd(3.0 * kDegree, axis.normalized()) *
                               views[i].world_from_view;
  }
}

void drop_poses(std::vector<RangeView>& views) {
  for (RangeView& view : views) {
    view.world_from_view = RigidMotion::Identity();
    view.pose = PoseKind::kAbsent;
  }
}

struct Mistakes {
  std::size_t missed = 0, wrong = 0, far = 0, truth = 0;  // far: not beside an outline.
};

Mistakes mistakes(const Scans& scans, const StaticBackground& found) {
  Mistakes total;
  for (std::size_t i = 0; i < scans.views.size(); ++i) {
    const Grid<std::uint8_t>& truth = scans.truth[i];
    for (int v = 0; v < truth.height(); ++v) {
      for (int u = 0; u < truth.width(); ++u) {
        if (!scans.views[i].has_sample(u, v)) continue;
        const int is = found.masks[i].empty() ? 0 : found.masks[i](u, v);
        total.truth += truth(u, v);
        if (is == truth(u, v)) continue;
        ++(is ? total.wrong : total.missed);
        bool outline = false;
        for (int dv = -1; dv <= 1; ++dv)
          for (int du = -1; du <= 1; ++du)
            outline =
                outline || (truth.contains(u + du, v + dv) && truth(u + du, v + dv) != truth(u, v));
        total.far += outline ? 0 : 1;
      }
    }
  }
  return total;
}

const Surface kPlate = plane({0, 0, 115}, {0.2, 0.1, -1});

class StaticBackgroundByPoses : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Views, StaticBackgroundByPoses, ::testing::Bool(),
                         [](const auto& test) -> std::string {
                           return test.param ? "WithPoses" : "WithoutPoses";
                         });

TEST_P(StaticBackgroundByPoses, APlateBehindATurningObjectIsFoundToThePixel) {
  Scans scans = turn(figure(), kPlate);
  if (GetParam())
    disturb_poses(scans.views);
  else
    drop_poses(scans.views);
  const StaticBackground found = find_static_background(scans.views);
  const Mistakes errors = mistakes(scans, found);
  ASSERT_GT(errors.truth, 100000u);
  EXPECT_EQ(found.views, 12u);
  EXPECT_EQ(errors.wrong, 0u);
  EXPECT_EQ(errors.far, 0u);
  EXPECT_LT(errors.missed, errors.truth / 2000);
  EXPECT_EQ(found.undecided, 0u);
}

// A depth camera flickers: bumps come and go in the middle of the plate.
TEST(StaticBackground, BumpsOfNoiseAreNoObjectThatThePlateTouches) {
  Scans scans = turn(figure(), kPlate);
  drop_poses(scans.views);
  for (std::size_t i = 0; i < scans.views.size(); ++i) {
    for (int bump = 0; bump < 10; ++bump) {
      const double phase = 10.0 * static_cast<double>(i) + bump;
      const double at_u = 80 + 70 * std::sin(1.3 * phase), at_v = 60 + 50 * std::cos(2.9 * phase);
      for (int v = 0; v < 120; ++v)
        for (int u = 0; u < 160; ++u)
          if (scans.truth[i](u, v))
            scans.views[i].range(u, v) -= static_cast<float>(
                2.0 * std::exp(-(std::pow(u - at_u, 2) + std::pow(v - at_v, 2)) / 25.0));
    }
  }
  const StaticBackground found = find_static_background(scans.views);
  const Mistakes errors = mistakes(scans, found);
  EXPECT_EQ(found.undecided, 0u);
  EXPECT_EQ(errors.wrong, 0u);
  EXPECT_LT(errors.missed, errors.truth / 20);  // The bumps themselves.
}

// Two views of twelve look through the middle of the ring.
// A finger before the lens, or a part of the arm that holds the camera: close to it, while the
// camera moves in steps that are small against what it looks at.
TEST(StaticBackground, AThingBeforeAMovingCameraIsFound) {
  const Surface room =
      nearest_of({figure(), sphere({30, 20, 10}, 15), plane({0, 0, 40}, {0.3, 0.2, -1}),
                  plane({-60, 0, 0}, {1, 0, -0.3})});
  const Surface thing = sphere({-3, 4, 25}, 4);
  Scans scans;
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector3d eye(4.0 * i - 22.0, 10.0 * std::sin(0.5 * i), -80.0);
    see(room, thing, look_at(eye, {0.5 * eye.x(), 0, 0}), scans);
  }
  disturb_poses(scans.views);
  const StaticBackground found = find_static_background(scans.views);
  const Mistakes errors = mistakes(scans, found);
  ASSERT_GT(errors.truth, 10000u);
  EXPECT_EQ(found.views, 12u);
  EXPECT_EQ(errors.far, 0u);
  EXPECT_LT(errors.missed, errors.truth / 50);
  EXPECT_EQ(found.undecided, 0u);
}

TEST(StaticBackground, APlateSeenThroughAGapOfTheObjectIsFound) {
  const Surface ring = nearest_of({sphere({0, 8, 8}, 8.5), sphere({0, -8, 8}, 8.5),
                                   sphere({0, 8, -8}, 8.5), sphere({0, -8, -8}, 8.5)});
  const Scans scans = turn(ring, kPlate, 12, 0.0);
  ASSERT_EQ(scans.truth[0](79, 59), 1);
  const Mistakes errors = mistakes(scans, find_static_background(scans.views));
  EXPECT_EQ(errors.wrong, 0u);
  EXPECT_EQ(errors.far, 0u);
}

TEST(StaticBackground, RemovingItLeavesTheObject) {
  Scans scans = turn(figure(), kPlate);
  const StaticBackground found = find_static_background(scans.views);
  const std::size_t before = scans.views[3].sample_count();
  remove_background(found, scans.views);
  std::size_t removed = 0;
  for (const std::uint8_t marked : found.masks[3]) removed += marked;
  EXPECT_EQ(scans.views[3].sample_count(), before - removed);
  for (std::size_t i = 0; i < found.masks[3].size(); ++i)
    EXPECT_FALSE(found.masks[3][i] && scans.views[3].normals[i].allFinite());
  EXPECT_THAT(describe(found, true).at(0), ::testing::HasSubstr("of 12 views stand still"));
  EXPECT_THAT(describe(found, true).at(0), ::testing::HasSubstr("--background keep"));
}

TEST_P(StaticBackgroundByPoses, NothingIsFoundWhereThereIsNone) {
  Scans scans = turn(figure(), std::nullopt);
  if (!GetParam()) drop_poses(scans.views);
  const StaticBackground found = find_static_background(scans.views);
  EXPECT_EQ(found.samples, 0u);
  EXPECT_TRUE(describe(found, true).empty());
}

// The body looks the same from all sides; only its handle moves.
TEST_P(StaticBackgroundByPoses, ASymmetricBodyOfAnObjectIsKept) {
  const Surface cup = nearest_of({cylinder(12, -10, 10), sphere({13, 0, 0}, 5)});
  Scans scans = turn(cup, std::nullopt, 12, 0.0);
  if (GetParam())
    disturb_poses(scans.views);
  else
    drop_poses(scans.views);
  EXPECT_EQ(find_static_background(scans.views).samples, 0u);
}

TEST_P(StaticBackgroundByPoses, ASymmetricFootIsKeptWhenThePlateBehindItIsLeftOut) {
  const Surface statue = nearest_of({figure(), cylinder(11, -20, -9)});
  Scans scans = turn(statue, kPlate, 12, 0.0);
  if (!GetParam()) drop_poses(scans.views);
  const Mistakes errors = mistakes(scans, find_static_background(scans.views));
  EXPECT_EQ(errors.wrong, 0u);
  EXPECT_EQ(errors.far, 0u);
}

// The floor turns in itself, so exact poses let most of the corner turn with the object.
TEST(StaticBackground, AFloorHidesNoWallThatStandsOnIt) {
  const RigidMotion first = look_at({80, 0, 15}, {0, 0, 0});
  const Eigen::Vector3d below = first.inverse() * Eigen::Vector3d(0, 0, -22);
  const Surface corner = nearest_of({kPlate, plane(below, first.linear().transpose().col(2))});
  const Scans scans = turn(figure(), corner);
  const StaticBackground found = find_static_background(scans.views);
  const Mistakes errors = mistakes(scans, found);
  EXPECT_EQ(found.views, 12u);
  EXPECT_EQ(errors.wrong, 0u);
  EXPECT_EQ(errors.far, 0u);
}

// A camera that moves along a wall sees it at the same ranges; the poses say that it is the scene.
TEST(StaticBackground, AWallThatTheCameraMovesAlongIsKept) {
  const Surface room = nearest_of({plane({0, 0, 115}, {0, 0, -1}), sphere({0, 0, 90}, 10)});
  std::vector<RangeView> views;
  for (int i = 0; i < 6; ++i) {
    RigidMotion pose = RigidMotion::Identity();
    pose.translation().x() = 5.0 * i - 12.0;
    RangeView view = render(room, kCamera, pose);
    testing::add_range_noise(view, kNoise, static_cast<std::uint32_t>(i + 1));
    views.push_back(view);
  }
  EXPECT_EQ(find_static_background(views).samples, 0u);
}

TEST(StaticBackground, ObjectsThatDoNotMoveAreKept) {
  Scans scans = turn(figure(), kPlate, 1);
  std::vector<RangeView> views(5, scans.views.front());
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_range_noise(views[i], kNoise, static_cast<std::uint32_t>(20 + i));
  EXPECT_EQ(find_static_background(views).samples, 0u);
}

TEST(StaticBackground, SomeOfManyViewsTellThatOfAll) {
  Scans scans = turn(figure(), kPlate, 70);
  const StaticBackground found = find_static_background(scans.views);
  const Mistakes errors = mistakes(scans, found);
  EXPECT_EQ(found.views, 70u);
  EXPECT_EQ(errors.wrong, 0u);
  EXPECT_EQ(errors.far, 0u);
}

TEST(StaticBackground, ViewsLoadedOneAtATimeHaveTheSame) {
  for (const int count : {6, 70}) {
    const Scans scans = turn(figure(), kPlate, count);
    const StaticBackground all = find_static_background(scans.views);
    const auto load = [&](std::size_t i) -> Result<std::shared_ptr<const RangeView>> {
      return std::make_shared<const RangeView>(scans.views[i]);
    };
    const StaticBackground loaded =
        testing::value_of(find_static_background(scans.views.size(), load));
    EXPECT_EQ(all.samples, loaded.samples);
    EXPECT_EQ(all.undecided, loaded.undecided);
    for (std::size_t i = 0; i < all.masks.size(); ++i)
      EXPECT_TRUE(std::equal(all.masks[i].begin(), all.masks[i].end(), loaded.masks[i].begin()));
  }
}

TEST(StaticBackground, AViewThatCannotBeLoadedIsAnError) {
  const auto load = [](std::size_t) -> Result<std::shared_ptr<const RangeView>> {
    return Error{ErrorKind::kBadInput, "damaged"};
  };
  EXPECT_THAT(find_static_background(5, load), testing::HasError(ErrorKind::kBadInput));
}

TEST(StaticBackground, ThreadsMakeNoDifference) {
  const Scans scans = turn(figure(), kPlate, 6);
  const auto found_on = [&](int threads) {
    return on_threads(threads, [&] { return find_static_background(scans.views); });
  };
  const StaticBackground one = found_on(1), three = found_on(3);
  EXPECT_EQ(one.samples, three.samples);
  for (std::size_t i = 0; i < one.masks.size(); ++i)
    EXPECT_TRUE(std::equal(one.masks[i].begin(), one.masks[i].end(), three.masks[i].begin()));
}

}  // namespace
}  // namespace relief
