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

}  // namespace
}  // namespace relief::fusion
