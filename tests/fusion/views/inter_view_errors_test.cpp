#include "fusion/views/inter_view_errors.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

constexpr double kRadius = 50.0;

std::vector<RangeView> views_of_a_sphere() {
  return testing::views_around(testing::sphere(Eigen::Vector3d::Zero(), kRadius), 12, 100, kRadius);
}

// Moves views along their optical axes, towards the object.
void shift_views(std::vector<RangeView>& views, const std::vector<double>& distances) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Eigen::Vector3d axis = views[i].world_from_view.linear().col(2);
    views[i].world_from_view.pretranslate(distances[i % distances.size()] * axis);
  }
}

std::vector<ViewSampler> samplers_of(const std::vector<RangeView>& views) {
  std::vector<ViewSampler> samplers;
  for (const RangeView& view : views)
    samplers.push_back(testing::value_of(ViewSampler::create(view, {})));
  return samplers;
}

RangeErrors errors_of(const std::vector<RangeView>& views) {
  return inter_view_errors(samplers_of(views));
}

double deviation_of(const std::vector<RangeView>& views) { return errors_of(views).stddev; }

TEST(InterViewErrors, OfExactViewsIsFarBelowTheSpacing) {
  const auto samplers = samplers_of(views_of_a_sphere());
  EXPECT_LT(inter_view_errors(samplers).stddev, 0.02 * samplers.front().spacing());
}

TEST(InterViewErrors, IsThatOfTheNoiseOfOneView) {
  auto views = views_of_a_sphere();
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_range_noise(views[i], 0.3, static_cast<std::uint32_t>(i));
  // Along the normal it is less than along the ray, and between samples they are averaged.
  EXPECT_NEAR(deviation_of(views), 0.22, 0.06);
}

TEST(InterViewErrors, HoldsWrongPosesThatTheNoiseOfOneViewDoesNotShow) {
  auto views = views_of_a_sphere();
  shift_views(views, {-3.0, -1.5, 0.0, 1.5, 3.0});
  const auto samplers = samplers_of(views);
  EXPECT_LT(samplers.front().noise(), 0.05);
  EXPECT_GT(inter_view_errors(samplers).stddev, 1.0);
  EXPECT_LT(inter_view_errors(samplers).stddev, 3.5);
}

TEST(InterViewErrors, GrowWithTheDistanceAsTheNoiseDoes) {
  for (const double exponent : {1.0, 2.0}) {
    const auto errors = errors_of(testing::near_and_far_views(kRadius, 0.1, exponent));
    // On the small side, by two standard errors.
    EXPECT_GT(errors.exponent, exponent - 0.4);
    EXPECT_LT(errors.exponent, exponent + 0.05);
    EXPECT_GT(errors.typical_range, 4.0 * kRadius);
    EXPECT_LT(errors.typical_range, 8.0 * kRadius);
  }
}

TEST(InterViewErrors, DoNotGrowWithTheDistanceWhereTheyAreTheSame) {
  EXPECT_LT(errors_of(testing::near_and_far_views(kRadius, 0.2, 0.0)).exponent, 0.1);
  auto views = views_of_a_sphere();
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_range_noise(views[i], 0.3, static_cast<std::uint32_t>(i));
  EXPECT_LT(errors_of(views).exponent, 0.5) << "all at one distance";
}

TEST(InterViewErrors, AreNoneOfTheSameViewOverAgain) {
  const auto views = views_of_a_sphere();
  const RangeErrors errors = errors_of(std::vector<RangeView>(5, views.front()));
  EXPECT_LT(errors.stddev, 1e-4);
  EXPECT_GE(errors.exponent, 0.0) << "not NaN";
  EXPECT_LE(errors.exponent, 2.0);
}

TEST(InterViewErrors, DoNotDependOnTheOrderOfTheViews) {
  auto views = testing::near_and_far_views(kRadius, 0.1, 2.0);
  shift_views(views, {0.05, -0.05, 0.02});
  const RangeErrors errors = errors_of(views);
  std::reverse(views.begin(), views.end());
  const RangeErrors reversed = errors_of(views);
  EXPECT_EQ(reversed.stddev, errors.stddev);
  EXPECT_EQ(reversed.typical_range, errors.typical_range);
  EXPECT_EQ(reversed.exponent, errors.exponent);
  EXPECT_GT(errors.exponent, 0.0);
}

TEST(InterViewErrors, IsZeroWhereNothingIsSeenTwice) {
  auto views = views_of_a_sphere();
  views.resize(1);
  EXPECT_EQ(deviation_of(views), 0.0);
  views.push_back(views.front());
  views.back().world_from_view.pretranslate(Eigen::Vector3d(1000.0, 0.0, 0.0));
  EXPECT_EQ(deviation_of(views), 0.0);
}

}  // namespace
}  // namespace relief::fusion
