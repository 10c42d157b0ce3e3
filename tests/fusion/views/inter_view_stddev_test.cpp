#include "fusion/views/inter_view_stddev.h"

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

double deviation_of(const std::vector<RangeView>& views) {
  return inter_view_stddev(samplers_of(views));
}

TEST(InterViewStddev, OfExactViewsIsFarBelowTheSpacing) {
  const auto samplers = samplers_of(views_of_a_sphere());
  EXPECT_LT(inter_view_stddev(samplers), 0.02 * samplers.front().spacing());
}

TEST(InterViewStddev, IsThatOfTheNoiseOfOneView) {
  auto views = views_of_a_sphere();
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_range_noise(views[i], 0.3, static_cast<std::uint32_t>(i));
  // Along the normal it is less than along the ray, and between samples they are averaged.
  EXPECT_NEAR(deviation_of(views), 0.22, 0.06);
}

TEST(InterViewStddev, HoldsWrongPosesThatTheNoiseOfOneViewDoesNotShow) {
  auto views = views_of_a_sphere();
  shift_views(views, {-3.0, -1.5, 0.0, 1.5, 3.0});
  const auto samplers = samplers_of(views);
  EXPECT_LT(samplers.front().noise(), 0.05);
  EXPECT_GT(inter_view_stddev(samplers), 1.0);
  EXPECT_LT(inter_view_stddev(samplers), 3.5);
}

TEST(InterViewStddev, DoesNotDependOnTheOrderOfTheViews) {
  auto views = views_of_a_sphere();
  shift_views(views, {0.5, -0.5, 0.2});
  const double deviation = deviation_of(views);
  std::reverse(views.begin(), views.end());
  EXPECT_EQ(deviation_of(views), deviation);
}

TEST(InterViewStddev, IsZeroWhereNothingIsSeenTwice) {
  auto views = views_of_a_sphere();
  views.resize(1);
  EXPECT_EQ(deviation_of(views), 0.0);
  views.push_back(views.front());
  views.back().world_from_view.pretranslate(Eigen::Vector3d(1000.0, 0.0, 0.0));
  EXPECT_EQ(deviation_of(views), 0.0);
}

}  // namespace
}  // namespace relief::fusion
