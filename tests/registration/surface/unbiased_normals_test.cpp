#include "registration/surface/unbiased_normals.h"

#include <numbers>

#include <gtest/gtest.h>

#include "registration/surface/normal_signal.h"
#include "tests/registration/relief_views.h"

namespace relief::registration {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
const Camera kCamera = Camera::pinhole(120, 100, {300, 300, 59.5, 49.5});

double mean_angle_deg(const Grid<Eigen::Vector3f>& a, const Grid<Eigen::Vector3f>& b) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!a[i].allFinite() || !b[i].allFinite()) continue;
    sum += std::asin(std::min(1.0, a[i].cross(b[i]).cast<double>().norm()));
    count += 1.0;
  }
  return kDegrees * sum / count;
}

TEST(UnbiasedNormals, LoseTheirBiasAndKeepTheirRelief) {
  const auto sphere = testing::sphere({0, 0, 400}, 80);
  const RangeView exact = testing::render(
      testing::engraved(sphere, {.slope_deg = 6.0, .shortest = 6.0, .longest = 10.0}), kCamera);
  RangeView view = exact;
  testing::add_flaws(view, {0.0, 0.0, 5.0}, 3);
  ASSERT_GT(mean_angle_deg(view.normals, exact.normals), 3.0);
  const auto unbiased =
      unbiased_normals(view, connect_samples(view), {.radius = 10, .spacing = 1.3});
  EXPECT_LT(mean_angle_deg(unbiased, exact.normals), 0.7);
}

TEST(UnbiasedNormals, OfExactViewsStayAsTheyAre) {
  const RangeView exact = testing::render(testing::sphere({0, 0, 400}, 80), kCamera);
  const auto unbiased =
      unbiased_normals(exact, connect_samples(exact), {.radius = 6, .spacing = 1.3});
  EXPECT_LT(mean_angle_deg(unbiased, exact.normals), 0.01);
}

// Where positions are noisy, more of them have to tell the mean slope.
TEST(UnbiasedNormals, StayUnbiasedAtHighNoise) {
  const RangeView exact = testing::render(testing::sphere({0, 0, 400}, 80), kCamera);
  RangeView view = exact;
  testing::add_flaws(view, {1.0, 0.0, 5.0}, 3);
  const auto edges = connect_samples(view);
  const auto error = [&](const UnbiasedNormalOptions& options) {
    return mean_angle_deg(unbiased_normals(view, edges, options), exact.normals);
  };
  EXPECT_LT(error({.noise = 1.3, .spacing = 1.3}), 1.5);
  EXPECT_GT(error({.radius = 4, .spacing = 1.3}), 2.0);
}

// Linear in the pixels, so that interpolation and differences are exact at every level.
TEST(NormalSignal, InterpolatesAtEveryLevel) {
  Grid<Eigen::Vector3f> normals(64, 48, Eigen::Vector3f::Zero());
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u)
      normals(u, v) = Eigen::Vector3f(0.001f * u, -0.002f * v, -1.0f).normalized();
  const NormalSignal signal(normals);
  ASSERT_GE(signal.levels(), 3);
  for (int level = 0; level < 3; ++level) {
    const auto sample = signal.at({30.3, 22.7}, level);
    ASSERT_TRUE(sample.has_value());
    const Eigen::Vector3d expected = Eigen::Vector3d(0.0303, -0.0454, -1.0).normalized();
    EXPECT_LT((sample->normal - expected).norm(), 1e-4);
    // As far as normals are kept.
    EXPECT_NEAR(sample->by_pixel(0, 0), 0.001, 3e-5);
    EXPECT_NEAR(sample->by_pixel(1, 1), -0.002, 3e-5);
  }
}

TEST(NormalSignal, EndsAtGapsAndBorders) {
  Grid<Eigen::Vector3f> normals(32, 32, Eigen::Vector3f(0, 0, -1));
  normals(10, 10).setConstant(std::numeric_limits<float>::quiet_NaN());
  const NormalSignal signal(normals);
  EXPECT_FALSE(signal.at({9.5, 9.5}, 0).has_value());
  EXPECT_FALSE(signal.at({8.5, 10.0}, 0).has_value());
  EXPECT_TRUE(signal.at({7.5, 9.5}, 0).has_value());
  EXPECT_FALSE(signal.at({0.5, 9.5}, 0).has_value());
  EXPECT_FALSE(signal.at({1e9, -1e9}, 0).has_value());
  EXPECT_TRUE(NormalSignal().empty());
}

}  // namespace
}  // namespace relief::registration
