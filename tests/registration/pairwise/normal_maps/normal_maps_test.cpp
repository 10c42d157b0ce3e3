#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/pairwise/icp.h"
#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/registration/relief_views.h"

namespace relief::registration {
namespace {

constexpr int kPixels = 160;
constexpr double kDistance = 400.0;  // One sample a unit in the middle of a view.
const Camera kCamera = Camera::pinhole(kPixels, kPixels, {kDistance, kDistance, 79.5, 79.5});

// Two views of a shape that geometry alone leaves free to slide.
struct SlidingPair {
  SlidingPair(const testing::Surface& surface, const RigidMotion& first, const RigidMotion& second)
      : target_view(testing::render(surface, kCamera, first)),
        source_view(testing::render(surface, kCamera, second)),
        truth(first.inverse() * second) {
    testing::add_flaws(target_view, {}, 1);
    testing::add_flaws(source_view, {}, 2);
  }

  IcpResult align(bool normal_maps, double turn, double shift) const {
    const ViewSurface target(target_view), source(source_view);
    RigidTangent offset;
    offset << turn * Eigen::Vector3d(0.5, -0.3, 0.8), shift * Eigen::Vector3d(0.7, -0.6, 0.4);
    const RigidMotion guess = truth * Eigen::Translation3d(source.centre()) *
                              motion_from_tangent(offset) * Eigen::Translation3d(-source.centre());
    IcpOptions options;
    options.normal_maps = normal_maps;
    return align_pair(source, target, guess, options);
  }
  double error(const IcpResult& found) const {
    return testing::mean_displacement(source_view, found.target_from_source, truth) /
           sample_spacing(target_view);
  }

  RangeView target_view, source_view;
  RigidMotion truth;
};

SlidingPair plate() {
  return {testing::engraved(testing::plane({0, 0, 0}, {0, 0, 1})),
          testing::look_at({-60, -20, kDistance}, {-10, 0, 0}, Eigen::Vector3d::UnitY()),
          testing::look_at({70, 50, kDistance}, {15, 10, 0}, {0.2, 1, 0})};
}

SlidingPair ball() {
  return {testing::engraved(testing::sphere({0, 0, 0}, 70)),
          testing::look_at({0, 0, kDistance + 50}, {0, 0, 0}, Eigen::Vector3d::UnitY()),
          testing::look_at({200, 80, kDistance - 30}, {0, 0, 0}, Eigen::Vector3d::UnitY())};
}

SlidingPair column() {
  return {testing::engraved(testing::cylinder(60)),
          testing::look_at({0, 0, kDistance + 50}, {0, 0, 0}, Eigen::Vector3d::UnitY()),
          testing::look_at({200, 20, kDistance - 30}, {0, 5, 0}, Eigen::Vector3d::UnitY())};
}

using ::testing::ElementsAre;
using ::testing::StartsWith;

std::vector<std::string> descriptions(const IcpResult& result) {
  std::vector<std::string> all;
  for (const auto& direction : result.degenerate_directions) all.push_back(direction.description);
  return all;
}

// What is known of the geometry alone, and with the normal maps, from two spacings off.
void expect_only_maps_hold(const SlidingPair& pair) {
  const auto geometry = pair.align(false, 0.02, 2.0);
  EXPECT_GT(pair.error(geometry), 1.0);
  EXPECT_TRUE(geometry.usable());
  const auto maps = pair.align(true, 0.02, 2.0);
  EXPECT_EQ(maps.termination, IcpTermination::kConverged);
  EXPECT_TRUE(maps.degenerate_directions.empty());
  EXPECT_LT(pair.error(maps), 0.05);
  // Six deviations along each axis hold the error, and none is far larger.
  const Eigen::Vector3d deviation = maps.covariance.diagonal().tail<3>().cwiseSqrt();
  EXPECT_LT(pair.error(maps), 6.0 * deviation.norm());
  EXPECT_LT(deviation.maxCoeff(), 0.1);
}

TEST(NormalMaps, HoldAFlatPlate) {
  const auto pair = plate();
  EXPECT_THAT(descriptions(pair.align(false, 0.02, 2.0)),
              ElementsAre(StartsWith("sliding along"), StartsWith("sliding along"),
                          StartsWith("turning about")));
  expect_only_maps_hold(pair);
}

TEST(NormalMaps, HoldASphere) {
  const auto pair = ball();
  EXPECT_THAT(descriptions(pair.align(false, 0.02, 2.0)),
              ElementsAre(StartsWith("turning about"), StartsWith("turning about"),
                          StartsWith("turning about")));
  expect_only_maps_hold(pair);
}

TEST(NormalMaps, HoldACylinder) {
  const auto pair = column();
  EXPECT_THAT(descriptions(pair.align(false, 0.02, 2.0)),
              ElementsAre(StartsWith("sliding along"), StartsWith("turning about")));
  expect_only_maps_hold(pair);
}

// Noise agrees on nothing: normal maps without relief do not pretend to hold anything.
TEST(NormalMaps, WithoutReliefLeaveAPlateFree) {
  const SlidingPair pair(
      testing::plane({0, 0, 0}, {0, 0, 1}),
      testing::look_at({-60, -20, kDistance}, {-10, 0, 0}, Eigen::Vector3d::UnitY()),
      testing::look_at({70, 50, kDistance}, {15, 10, 0}, {0.2, 1, 0}));
  const auto found = pair.align(true, 0.01, 2.0);
  EXPECT_EQ(found.degenerate_directions.size(), 3u);
  EXPECT_NEAR(pair.error(found), 1.7, 0.3);  // Left where it was.
}

TEST(NormalMaps, DoNoHarmToAViewThatGeometryHolds) {
  for (const double noise_deg : {0.0, 1.5}) {
    double with = 0.0, without = 0.0;
    const auto exact = testing::ring_of_views({.views = 8, .noise = 0.0});
    const RigidMotion truth = exact[0].world_from_view.inverse() * exact[1].world_from_view;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
      RangeView a = exact[0], b = exact[1];
      const testing::SensorFlaws flaws{0.3, noise_deg, noise_deg > 0.0 ? 4.0 : 0.0};
      testing::add_flaws(a, flaws, 10 * seed);
      testing::add_flaws(b, flaws, 10 * seed + 1);
      const ViewSurface target(a), source(b);
      const auto error = [&](bool maps) {
        const auto found = align_pair(source, target, truth, {.normal_maps = maps});
        return testing::mean_displacement(b, found.target_from_source, truth) / target.spacing();
      };
      with += error(true) / 4.0;
      without += error(false) / 4.0;
    }
    EXPECT_LT(with, 1.05 * without);
    EXPECT_LT(with, 0.1);
  }
}

// Three views of a plate, all poses but the first disturbed, aligned jointly.
TEST(NormalMaps, HoldAPlateOfThreeViewsJointly) {
  const auto surface = testing::engraved(testing::plane({0, 0, 0}, {0, 0, 1}));
  std::vector<RangeView> views;
  for (const Eigen::Vector3d& at :
       {Eigen::Vector3d(-60, -20, 0), Eigen::Vector3d(70, 50, 0), Eigen::Vector3d(10, -70, 0)})
    views.push_back(testing::render(surface, kCamera,
                                    testing::look_at(at + kDistance * Eigen::Vector3d::UnitZ(),
                                                     0.2 * at, Eigen::Vector3d::UnitY())));
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_flaws(views[i], {}, static_cast<std::uint32_t>(20 + i));
  const auto truth = testing::poses_of(views);
  const auto disturbed = testing::perturbed(views, Eigen::Vector3d::Zero(), 0.01, 1.5);
  const auto error = [&](const AlignOptions& options) {
    const auto aligned = align_views(disturbed, options);
    for (const auto& pair : aligned->pairs)
      EXPECT_EQ(pair.degenerate_directions.empty(), options.surface.normal_signal);
    const auto errors = testing::mean_displacements(views, aligned->world_from_view(), truth);
    return *std::max_element(errors.begin(), errors.end()) / sample_spacing(views[0]);
  };
  EXPECT_LT(error({}), 0.1);
  EXPECT_GT(error({.surface = {.normal_signal = false}}), 0.5);
}

}  // namespace
}  // namespace relief::registration
