#include "scan/simulation/sensors/sensor_errors.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "scan/base/counter_random.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::simulation {
namespace {

const Camera kCamera = Camera::pinhole(320, 240, {300, 300, 159.5, 119.5});

RangeView plane_view() {
  return testing::render(testing::plane({0, 0, 10}, {0.3, -0.2, -1}), kCamera);
}

RangeView sphere_view() { return testing::render(testing::sphere({0, 0, 10}, 3.0), kCamera); }

double angle(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3d x = a.cast<double>(), y = b.cast<double>();
  return std::atan2(x.cross(y).norm(), x.dot(y));
}

std::vector<double> normal_angles(const RangeView& a, const RangeView& b) {
  std::vector<double> angles;
  for (std::size_t i = 0; i < a.normals.size(); ++i)
    if (a.normals[i].allFinite()) angles.push_back(angle(a.normals[i], b.normals[i]));
  return angles;
}

double rms(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

TEST(CounterRandom, HasTheMomentsOfTheNormalDistribution) {
  const CounterRandom random(7, 3);
  constexpr int kCount = 200000;
  double moments[5] = {};
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal(static_cast<std::uint64_t>(i));
    for (int k = 1; k <= 4; ++k) moments[k] += std::pow(x, k) / kCount;
  }
  EXPECT_NEAR(moments[1], 0.0, 0.01);
  EXPECT_NEAR(moments[2], 1.0, 0.015);
  EXPECT_NEAR(moments[3], 0.0, 0.04);
  EXPECT_NEAR(moments[4], 3.0, 0.12);
}

TEST(CounterRandom, StreamsAndSeedsAreIndependent) {
  const CounterRandom a(1, 0), b(1, 1), c(2, 0);
  double ab = 0.0, ac = 0.0, next = 0.0;
  constexpr int kCount = 100000;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    ab += a.normal(i) * b.normal(i) / kCount;
    ac += a.normal(i) * c.normal(i) / kCount;
    next += a.normal(i) * a.normal(i + 1) / kCount;
  }
  EXPECT_NEAR(ab, 0.0, 0.015);
  EXPECT_NEAR(ac, 0.0, 0.015);
  EXPECT_NEAR(next, 0.0, 0.015);
}

// The stream of numbers is part of what a seed promises.
TEST(CounterRandom, KeepsItsNumbers) {
  const CounterRandom random(1, 2);
  EXPECT_EQ(random.bits(0), CounterRandom(1, 2).bits(0));
  EXPECT_NE(random.bits(0), random.bits(1));
  for (std::uint64_t i = 0; i < 1000; ++i) {
    EXPECT_GT(random.uniform(i), 0.0);
    EXPECT_LT(random.uniform(i), 1.0);
  }
}

TEST(RangeNoise, IsWhiteWithTheStatedLengthAlongTheRay) {
  const RangeView exact = plane_view();
  RangeView noisy = exact;
  add_range_noise(noisy, 0.02, {5, 1});
  std::vector<double> lengths;
  double sum = 0.0, neighbours = 0.0;
  for (int v = 0; v < exact.height(); ++v) {
    for (int u = 0; u < exact.width(); ++u) {
      const double length =
          (noisy.range(u, v) - exact.range(u, v)) * exact.camera.ray(u, v).direction.norm();
      if (u > 0) neighbours += length * lengths.back();
      lengths.push_back(length);
      sum += length;
    }
  }
  const double count = static_cast<double>(lengths.size());
  EXPECT_NEAR(rms(lengths), 0.02, 0.02 * 0.01);
  EXPECT_NEAR(sum / count, 0.0, 4.0 * 0.02 / std::sqrt(count));
  EXPECT_NEAR(neighbours / count, 0.0, 4.0 * 0.0004 / std::sqrt(count));
}

TEST(NormalNoise, HasTheStatedDeviationAboutEachAxis) {
  const RangeView exact = plane_view();
  RangeView noisy = exact;
  const double sigma = 0.03;
  add_normal_noise(noisy, sigma, {5, 2});
  const auto angles = normal_angles(exact, noisy);
  EXPECT_NEAR(rms(angles), sigma * std::sqrt(2.0), 0.01 * sigma);
  double mean = 0.0;
  for (const double a : angles) mean += a / static_cast<double>(angles.size());
  EXPECT_NEAR(mean, sigma * std::sqrt(std::acos(-1.0) / 2.0), 0.02 * sigma);
}

TEST(NormalBias, HasTheStatedRms) {
  const RangeView exact = sphere_view();
  RangeView biased = exact;
  add_normal_bias(biased, 0.07, 3.0, {5, 3});
  // Normals near the silhouette may be put back to face the sensor.
  EXPECT_NEAR(rms(normal_angles(exact, biased)), 0.07, 0.001);
}

TEST(NormalBias, IsSmoothAtScalesBelowItsWavelength) {
  const RangeView exact = plane_view();
  RangeView biased = exact;
  const double wavelength = 4.0, amplitude = 0.07;
  add_normal_bias(biased, amplitude, wavelength, {9, 4});
  std::vector<double> slopes;
  for (int v = 0; v < exact.height(); ++v)
    for (int u = 1; u < exact.width(); ++u)
      slopes.push_back(angle(biased.normals(u, v), biased.normals(u - 1, v)) /
                       (exact.point(u, v) - exact.point(u - 1, v)).norm());
  const double pi = std::acos(-1.0);
  EXPECT_LT(rms(slopes), amplitude * 2.0 * pi / wavelength);
  EXPECT_GT(rms(slopes), amplitude * 2.0 * pi / (2.0 * wavelength) / 4.0);
}

TEST(NormalBias, TurnsFineReliefAsAWhole) {
  RangeView view = plane_view();
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      view.normals(u, v) =
          (view.normals(u, v) + 0.3f * Eigen::Vector3f(u % 2, v % 2, 0)).normalized();
  RangeView biased = view;
  add_normal_bias(biased, 0.1, 20.0, {2, 0});
  // The angle between neighbours stays what it was.
  for (int u = 1; u < view.width(); ++u)
    EXPECT_NEAR(angle(biased.normals(u, 50), biased.normals(u - 1, 50)),
                angle(view.normals(u, 50), view.normals(u - 1, 50)), 0.005);
}

TEST(NormalErrors, LeaveUnitNormalsThatFaceTheSensor) {
  RangeView view = sphere_view();
  add_normal_bias(view, 0.3, 3.0, {1, 0});
  add_normal_noise(view, 0.3, {1, 1});
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_normal(u, v)) continue;
      EXPECT_NEAR(view.normals(u, v).norm(), 1.0, 1e-6);
      EXPECT_LT(view.normals(u, v).cast<double>().dot(view.camera.ray(u, v).direction), 0.0);
    }
  }
}

TEST(RandomMotion, HasTheStatedAmounts) {
  const Eigen::Vector3d centre(3, -2, 8);
  for (std::uint64_t stream = 0; stream < 20; ++stream) {
    const RigidMotion motion = random_motion(0.05, 0.7, centre, {3, stream});
    EXPECT_NEAR(rotation_angle(motion), 0.05, 1e-12);
    EXPECT_NEAR((motion * centre - centre).norm(), 0.7, 1e-12);
  }
}

}  // namespace
}  // namespace relief::simulation
