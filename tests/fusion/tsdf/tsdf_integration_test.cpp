#include "fusion/tsdf/tsdf_integration.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

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

}  // namespace
}  // namespace relief::fusion
