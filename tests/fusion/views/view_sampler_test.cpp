#include "fusion/views/view_sampler.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "fusion/tsdf/tsdf_integration.h"
#include "fusion/views/paged_surface.h"
#include "tests/fusion/scenes.h"
#include "tests/support/geometry_matchers.h"
#include "tests/support/parameter_names.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

ViewSampler sampler_of(const RangeView& view) { return value_of(ViewSampler::create(view, {})); }

const RigidMotion kPose = testing::look_at({10, 20, 200}, {1, 2, 3}, Eigen::Vector3d::UnitY());

// The rays of `camera` as a table, without a projection.
Camera as_table(const Camera& camera) {
  Grid<Ray> rays(camera.width(), camera.height());
  for (int v = 0; v < camera.height(); ++v)
    for (int u = 0; u < camera.width(); ++u) rays(u, v) = camera.ray(u, v);
  return Camera::ray_table(rays, std::nullopt);
}

std::vector<Camera> cameras() {
  const PinholeIntrinsics k{300.0, 310.0, 30.0, 29.0};
  return {Camera::pinhole(60, 60, k), as_table(Camera::pinhole(60, 60, k)),
          Camera::orthographic(60, 60, {-20, -20, 0}, {0.7, 0, 0}, {0, 0.7, 0}, {0, 0, 1})};
}

class ViewSamplerOfCamera : public ::testing::TestWithParam<Camera> {};
INSTANTIATE_TEST_SUITE_P(Cameras, ViewSamplerOfCamera, ::testing::ValuesIn(cameras()),
                         testing::PrintedName());

TEST_P(ViewSamplerOfCamera, DistancesToAPlaneAreExact) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, 1.0).normalized(), at(1, 2, 3);
  const ViewSampler sampler = sampler_of(render(testing::plane(at, normal), GetParam(), kPose));
  for (const double distance : {-2.0, 0.0, 1.0, 10.0}) {
    const auto seen = sampler.observe(at + distance * normal, 0.0);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->distance, distance, 1e-3);
    EXPECT_NEAR((seen->normal - normal).norm(), 0.0, 1e-5);
    EXPECT_GT(seen->weight, 0.5);
    EXPECT_LE(seen->clearance, std::max(0.0, distance) + 1e-3);
  }
}

TEST(ViewSampler, OnASphereTheErrorFallsFasterThanTheSquareOfTheSpacing) {
  double last = 0.0;
  for (const int size : {20, 40, 80}) {
    const double f = 4.0 * size, c = 0.5 * (size - 1);
    const ViewSampler sampler = sampler_of(
        render(testing::sphere({0, 0, 0}, 40.0), Camera::pinhole(size, size, {f, f, c, c}),
               testing::look_at({0, 0, 300}, {0, 0, 0}, Eigen::Vector3d::UnitY())));
    double worst = 0.0;
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d p =
          40.0 * Eigen::Vector3d(0.3 * std::cos(i), 0.3 * std::sin(i * 1.7), 1.0).normalized();
      const auto seen = sampler.observe(p, 0.0);
      ASSERT_TRUE(seen);
      worst = std::max(worst, std::abs(seen->distance));
    }
    if (last > 0.0) {
      EXPECT_LT(worst, last / 5.0);
    }
    last = worst;
  }
}

TEST(ViewSampler, SteepViewsMeasureFromTheFootOfAPoint) {
  const ViewSampler sampler = sampler_of(
      render(testing::sphere({0, 0, 0}, 40.0), Camera::pinhole(160, 160, {560, 560, 79.5, 79.5}),
             testing::look_at({0, 0, 300}, {0, 0, 0}, Eigen::Vector3d::UnitY())));
  double at_once = 0.0, at_foot = 0.0;
  for (int i = 0; i < 200; ++i) {  // 62 to 64 degrees from the direction of view, 1 off the surface
    const double slope = 1.08 + 0.0002 * i;
    const Eigen::Vector3d normal(std::sin(slope) * std::cos(i), std::sin(slope) * std::sin(i),
                                 std::cos(slope));
    for (const double distance : {-1.0, 1.0}) {
      const Eigen::Vector3d p = (40.0 + distance) * normal;
      const auto once = sampler.observe(p, 0.0), twice = sampler.observe(p, 2.0);
      ASSERT_TRUE(once && twice) << slope << " " << distance;
      at_once = std::max(at_once, std::abs(once->distance - distance));
      at_foot = std::max(at_foot, std::abs(twice->distance - distance));
    }
  }
  EXPECT_GT(at_once, 0.05) << "the surface curves away";
  EXPECT_LT(at_foot, 0.2 * at_once);
}

TEST_P(ViewSamplerOfCamera, LeavesOutOnlyBoxesItKnowsNothingAbout) {
  std::mt19937 random(7);
  const auto number = [&](double least, double most) {
    return least + (most - least) * static_cast<double>(random()) / 4294967295.0;
  };
  constexpr double kReach = 3.0;
  const testing::Surface sphere = testing::sphere({1, 2, 3}, 15.0);
  const ViewSampler sampler = sampler_of(render(sphere, GetParam(), kPose));
  EXPECT_FALSE(sampler.concerns(Eigen::AlignedBox3d(), kReach)) << "an empty box";
  int left_out = 0;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d low(number(-25, 25), number(-25, 25), number(-25, 25));
    const Eigen::AlignedBox3d box(low, low + Eigen::Vector3d::Constant(number(1.0, 8.0)));
    if (sampler.concerns(box, kReach)) continue;
    ++left_out;
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d p = box.min() + box.sizes().cwiseProduct(Eigen::Vector3d(
                                                number(0, 1), number(0, 1), number(0, 1)));
      const auto seen = sampler.observe(p, 0.0);
      if (!seen) continue;
      EXPECT_LT(seen->distance, 0.0);
      EXPECT_GE(seen->range_gap, kReach);
    }
  }
  EXPECT_GT(left_out, 300);
  EXPECT_LT(left_out, 950);
}

TEST_P(ViewSamplerOfCamera, TellsFarPointsFromNearOnesByDepth) {
  std::mt19937 random(8);
  const auto number = [&] { return -25.0 + 50.0 * static_cast<double>(random()) / 4294967295.0; };
  constexpr double kReach = 3.0;
  const ViewSampler sampler =
      sampler_of(render(testing::sphere({1, 2, 3}, 15.0), GetParam(), kPose));
  int in_front = 0, behind = 0, near = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto quad = sampler.quad_on_ray_of({number(), number(), number()});
    if (!quad) continue;
    const auto seen = sampler.observe(*quad, 0.0);
    ASSERT_TRUE(seen);
    const ViewSampler::Side side = sampler.side(*quad, kReach);
    if (side == ViewSampler::Side::kNear) {
      ++near;
      continue;
    }
    EXPECT_GE(seen->range_gap, kReach - 1e-4);
    if (side == ViewSampler::Side::kInFront) {
      ++in_front;
      EXPECT_GT(seen->distance, 0.0);
    } else {
      ++behind;
      EXPECT_LT(seen->distance, 0.0);
    }
  }
  EXPECT_GT(in_front, 100);
  EXPECT_GT(behind, 100);
  EXPECT_GT(near, 50);
}

TEST(ViewSampler, SaysNothingOutsideItsSamples) {
  RangeView view = render(testing::plane({0, 0, 0}, {0, 0, 1}), cameras()[0], kPose);
  for (int v = 26; v < 33; ++v)
    for (int u = 27; u < 34; ++u) view.range(u, v) = kNoSample;
  const ViewSampler sampler = sampler_of(view);
  EXPECT_FALSE(sampler.observe({1000, 0, 0}, 0.0));
  EXPECT_FALSE(sampler.observe(kPose * Eigen::Vector3d(0, 0, -5), 0.0));
  EXPECT_FALSE(sampler.observe(kPose * view.camera.ray(30, 29).at(190.0), 0.0));
}

TEST(ViewSampler, WeightsVanishTowardsTheSilhouette) {
  const RangeView view = render(testing::plane({0, 0, 0}, {0, 0, 1}), cameras()[0], kPose);
  const ViewSampler sampler = sampler_of(view);
  double last = 0.0;
  for (int u = 0; u < 8; ++u) {
    const auto seen =
        sampler.observe(kPose * view.camera.ray_at(u + 0.5, 30).at(view.range(u, 30)), 0.0);
    ASSERT_TRUE(seen);
    if (u < 6) {
      EXPECT_GT(seen->weight, last);
    }
    last = seen->weight;
  }
}

TEST(ViewSampler, StrayPatchesAndSamplesWithoutConfidenceAreLeftOut) {
  RangeView view = render(testing::plane({0, 0, 0}, {0, 0, 1}), cameras()[0], kPose);
  for (int v = 0; v < 60; ++v)
    for (int u = 0; u < 60; ++u)
      if (u > 3 || v > 3) view.range(u, v) = kNoSample;
  EXPECT_TRUE(sampler_of(view).empty());
  view = render(testing::plane({0, 0, 0}, {0, 0, 1}), cameras()[0], kPose);
  view.confidence = Grid<float>(60, 60, 0.0f);
  EXPECT_TRUE(sampler_of(view).empty());
}

TEST(ViewSampler, KnownDeviationsTakeThePlaceOfConfidence) {
  RangeView view = render(testing::plane({0, 0, 0}, {0, 0, 1}), cameras()[0],
                          testing::look_at({0, 0, 200}, {0, 0, 0}, Eigen::Vector3d::UnitY()));
  view.confidence = Grid<float>(60, 60, 0.5f);
  PagedSurfaceOptions options;
  const double plain = surface_of(view, options).pixels(30, 30).weight;
  view.deviation = Grid<float>(60, 60, 0.1f);
  view.deviation(20, 20) = static_cast<float>(kNoSample);
  EXPECT_NEAR(surface_of(view, options).pixels(30, 30).weight, plain, 1e-6) << "no nominal one";
  options.weights.nominal_deviation = 0.2;
  const PagedSurface surface = surface_of(view, options);
  EXPECT_NEAR(surface.pixels(30, 30).weight / plain, 4.0 / 0.5, 0.05);
  EXPECT_NEAR(surface.pixels(20, 20).weight / plain, 1.0, 0.05) << "unknown there";
}

// A depth camera before a board, with a wall at fifteen times its distance in the right third. The
// noise grows with the square of the range.
RangeView board_before_a_far_wall() {
  const Camera camera = Camera::pinhole(120, 90, {150.0, 150.0, 59.5, 44.5});
  RangeView view = render(testing::plane({0, 0, 0}, {0, 0, 1}), camera,
                          testing::look_at({0, 0, 200}, {0, 0, 0}, Eigen::Vector3d::UnitY()));
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int v = 0; v < 90; ++v) {
    for (int u = 0; u < 120; ++u) {
      if (u >= 80) view.range(u, v) *= 15.0;
      view.range(u, v) += 0.1 * normal(random) * std::pow(view.range(u, v) / 200.0, 2);
    }
  }
  return view;
}

TEST(ViewSampler, FarSamplesOfMuchNoiseTellOnlyWhichSpaceIsEmpty) {
  const RangeView view = board_before_a_far_wall();
  const ViewSampler sampler = sampler_of(view);
  EXPECT_NEAR(static_cast<double>(sampler.noisy()), 40.0 * 90.0, 0.1 * 40.0 * 90.0);
  Eigen::AlignedBox3d measured;
  sampler.for_surface_points([&](const Eigen::Vector3d& p) { measured.extend(p); });
  EXPECT_LT(std::abs(measured.min().z()), 10.0);
  sampler.for_scattered_samples(
      [&](const Eigen::Vector3d& p) { EXPECT_LT(std::abs(p.z()), 10.0); });

  const RigidMotion& pose = view.world_from_view;
  const Camera& camera = view.camera;
  const auto before_wall = sampler.observe(pose * camera.ray(100, 45).at(300.0), 0.0);
  ASSERT_TRUE(before_wall);
  EXPECT_TRUE(before_wall->noisy);
  EXPECT_GT(before_wall->clearance, 10.0);
  const auto before_board = sampler.observe(pose * camera.ray(40, 45).at(190.0), 0.0);
  ASSERT_TRUE(before_board);
  EXPECT_FALSE(before_board->noisy);

  std::vector<ViewSampler> views;
  views.push_back(sampler_of(view));
  TsdfIntegrator integrator(views, 300.0, 1.0);
  EXPECT_FALSE(integrator.collect(pose * camera.ray(100, 45).at(2990.0)).measured);
  EXPECT_TRUE(integrator.collect(pose * camera.ray(40, 45).at(199.0)).measured);
}

TEST(ViewSampler, KnownDeviationsTellFarSamplesOfMuchNoise) {
  RangeView view = board_before_a_far_wall();
  view.deviation = Grid<float>(120, 90, 0.1f);
  EXPECT_EQ(sampler_of(view).noisy(), 0u);
  for (int v = 20; v < 30; ++v) view.deviation(100, v) = 1.1f;
  EXPECT_EQ(sampler_of(view).noisy(), 0u) << "less than the spacing of 1.3";
  for (int v = 20; v < 30; ++v) view.deviation(100, v) = 1.6f;
  EXPECT_EQ(sampler_of(view).noisy(), 10u);
}

TEST(ViewSampler, MeasuresTheNoise) {
  RangeView view = render(testing::plane({0, 0, 0}, {0, 0, 1}), cameras()[0],
                          testing::look_at({0, 0, 200}, {0, 0, 0}, Eigen::Vector3d::UnitY()));
  EXPECT_NEAR(sampler_of(view).noise(), 0.0, 1e-9);
  testing::add_range_noise(view, 0.2, 5);
  EXPECT_NEAR(sampler_of(view).noise(), 0.2, 0.02);
}

}  // namespace
}  // namespace relief::fusion
