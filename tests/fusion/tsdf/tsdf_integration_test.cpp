#include "fusion/tsdf/tsdf_integration.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

constexpr double kTruncation = 3.0, kSpacing = 1.0;

std::vector<ViewSampler> samplers_of(const std::vector<RangeView>& views) {
  std::vector<ViewSampler> samplers;
  for (const RangeView& view : views) samplers.push_back(value_of(ViewSampler::create(view, {})));
  return samplers;
}

TEST(TsdfSample, IsTheSameAsFarAsEnough) {
  const auto samplers =
      samplers_of(testing::views_around(testing::sphere({0, 0, 0}, 20.0), 8, 60, 24.0));
  TsdfIntegrator collector(samplers, kTruncation, kSpacing);
  std::mt19937 random(3);
  const auto number = [&] { return -30.0 + 60.0 * static_cast<double>(random()) / 4294967295.0; };
  int measured = 0, empty = 0, unknown = 0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d point(number(), number(), number());
    constexpr double kEnough = 3.0;
    const TsdfSample all = collector.collect(point);
    const TsdfSample enough = collector.collect_as_far_as(kEnough, point);
    ASSERT_EQ(enough.measured, all.measured);
    ASSERT_EQ(std::min(enough.clearance, kEnough), std::min(all.clearance, kEnough));
    if (all.measured) {
      ASSERT_EQ(enough.distance, all.distance);
      if (std::abs(all.distance) < kSpacing) {
        EXPECT_NEAR(all.distance, point.norm() - 20.0, 0.1);
      }
    }
    ++(all.measured ? measured : all.clearance > 0.0 ? empty : unknown);
  }
  EXPECT_GT(measured, 300);
  EXPECT_GT(empty, 300);
  EXPECT_GT(unknown, 300);
}

TEST(TsdfSample, ReachesFartherWhereViewsErrMore) {
  auto samplers = samplers_of(testing::views_around(testing::sphere({0, 0, 0}, 20.0), 1, 80, 24.0));
  const Eigen::Vector3d towards = -samplers[0].direction();
  const double range = samplers[0].range_of(20.0 * towards);
  const auto measured_at = [&](double distance) {
    TsdfIntegrator collector(samplers, kTruncation, kSpacing);
    collector.focus(Eigen::AlignedBox3d(Eigen::Vector3d((20.0 + distance) * towards)));
    return collector.collect((20.0 + distance) * towards).measured;
  };
  EXPECT_TRUE(measured_at(0.9 * kTruncation));
  EXPECT_FALSE(measured_at(1.1 * kTruncation));
  // Twice the error, thus twice the distance.
  samplers[0].set_range_errors({.stddev = 1.0, .typical_range = 0.5 * range, .exponent = 1.0});
  EXPECT_TRUE(measured_at(1.8 * kTruncation));
  EXPECT_FALSE(measured_at(2.2 * kTruncation));
  EXPECT_TRUE(measured_at(-1.8 * kTruncation));
  EXPECT_FALSE(measured_at(-2.2 * kTruncation));
  // Errors that are small beside the truncation do not matter.
  samplers[0].set_range_errors({.stddev = 0.01, .typical_range = 0.5 * range, .exponent = 1.0});
  EXPECT_TRUE(measured_at(0.9 * kTruncation));
  EXPECT_FALSE(measured_at(1.1 * kTruncation));
  // Half the error.
  samplers[0].set_range_errors({.stddev = 1.0, .typical_range = 2.0 * range, .exponent = 1.0});
  EXPECT_TRUE(measured_at(0.9 * kTruncation));
  EXPECT_FALSE(measured_at(1.1 * kTruncation));
}

// Two views that see a plane apart from each other, one with a tenth of the other's deviation.
std::vector<ViewSampler> planes_apart(double deviation, double gap) {
  const Camera camera = Camera::pinhole(80, 80, {100.0, 100.0, 39.5, 39.5});
  PagedSurfaceOptions options;
  options.weights.nominal_deviation = deviation;
  std::vector<ViewSampler> samplers;
  for (const int i : {0, 1}) {
    RangeView view = render(testing::plane({0, 0, i * gap}, {0, 0, 1}), camera,
                            testing::look_at({0, 0, 100}, {0, 0, 0}, Eigen::Vector3d::UnitY()));
    view.deviation = Grid<float>(80, 80, static_cast<float>(i == 0 ? deviation : 0.1 * deviation));
    samplers.push_back(value_of(ViewSampler::create(view, options)));
  }
  return samplers;
}

TEST(TsdfSample, WeighsByErrorsBeyondThoseThatSamplesKnow) {
  constexpr double kDeviation = 0.1, kGap = 0.5;
  auto samplers = planes_apart(kDeviation, kGap);
  const auto sample = [&] {
    TsdfIntegrator collector(samplers, kTruncation, kSpacing);
    return collector.collect({0.0, 0.0, 0.5 * kGap});
  };
  // The zero set lies at the mean by inverse variances, so many gaps from the first plane.
  const auto expect_mean_at = [&](double variance, double more_precise) {
    const double share = (1.0 / more_precise) / (1.0 / variance + 1.0 / more_precise);
    const TsdfSample seen = sample();
    EXPECT_NEAR(seen.distance, (0.5 - share) * kGap, 0.01 * kGap);
    EXPECT_NEAR(kDeviation * kDeviation / seen.information,
                1.0 / (1.0 / variance + 1.0 / more_precise), 0.02 * variance);
  };
  expect_mean_at(0.01, 0.0001);
  for (ViewSampler& sampler : samplers)
    sampler.set_range_errors(
        {.stddev = 0.5, .nominal_deviation = kDeviation, .excess_variance = 0.25});
  expect_mean_at(0.26, 0.2501);
}

TEST(TsdfSample, SpaceIsEmptyTwoDeviationsInFrontOfASurface) {
  auto samplers = planes_apart(0.1, 0.0);
  samplers.pop_back();
  const auto clearance_at = [&](double height) {
    TsdfIntegrator collector(samplers, kTruncation, kSpacing);
    return collector.collect({0.0, 0.0, height}).clearance;
  };
  EXPECT_NEAR(clearance_at(1.0), 1.0, 1e-3) << "nothing known of errors";
  for (ViewSampler& sampler : samplers)
    sampler.set_range_errors({.stddev = 0.3, .nominal_deviation = 0.1, .excess_variance = 0.08});
  EXPECT_NEAR(clearance_at(1.0), 1.0 - 2.0 * 0.3, 1e-2);
  EXPECT_EQ(clearance_at(0.5), 0.0);
  for (ViewSampler& sampler : samplers) sampler.set_range_errors({.stddev = 0.2});
  EXPECT_NEAR(clearance_at(1.0), 1.0 - 2.0 * 0.2, 1e-2) << "samples know no deviations";
}

}  // namespace
}  // namespace relief::fusion
