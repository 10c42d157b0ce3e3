#include "fusion/views/contradicted_views.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fusion/views/inter_view_errors.h"
#include "fusion/views/unshared_samples.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::value_of;

constexpr double kRadiusOfTorus = 47.0, kNoise = 0.1;

std::vector<RangeView> views_of_a_torus() {
  static const auto kExact = testing::views_around(
      testing::traced(testing::torus_distance(35.0, 12.0)), 20, 60, kRadiusOfTorus);
  auto views = kExact;
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_range_noise(views[i], kNoise, static_cast<std::uint32_t>(i));
  return views;
}

// Moves a view along its optical axis, towards the object.
void shift_view(RangeView& view, double distance) {
  view.world_from_view.pretranslate(
      Eigen::Vector3d(distance * view.world_from_view.linear().col(2)));
}

std::vector<ViewSampler> prepared(const std::vector<RangeView>& views) {
  std::vector<ViewSampler> samplers;
  for (const RangeView& view : views) samplers.push_back(value_of(ViewSampler::create(view, {})));
  const RangeErrors errors = inter_view_errors(samplers);
  for (ViewSampler& sampler : samplers) sampler.set_range_errors(errors);
  return samplers;
}

std::vector<std::size_t> contradicted(const std::vector<RangeView>& views) {
  const auto samplers = prepared(views);
  const auto judged = judge_views(samplers, samplers.front().range_errors());
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < judged.size(); ++i)
    if (judged[i].contradicted) found.push_back(i);
  return found;
}

TEST(ContradictedViews, AreNoneOfRightOnes) {
  EXPECT_THAT(contradicted(views_of_a_torus()), IsEmpty());
}

TEST(ContradictedViews, AreThoseFarFromWhereOthersAgree) {
  auto views = views_of_a_torus();
  shift_view(views[3], 5.0);
  EXPECT_THAT(contradicted(views), ElementsAre(3u));
  shift_view(views[3], -10.0);
  EXPECT_THAT(contradicted(views), ElementsAre(3u)) << "behind what the others measured";
  shift_view(views[7], 4.0);
  EXPECT_THAT(contradicted(views), ElementsAre(3u, 7u));
  std::ranges::reverse(views);
  EXPECT_THAT(contradicted(views), ElementsAre(12u, 16u));
}

TEST(ContradictedViews, AreThoseThatOthersSeeThrough) {
  auto views = views_of_a_torus();
  shift_view(views[3], -20.0);
  EXPECT_THAT(contradicted(views), ElementsAre(3u));
}

TEST(ContradictedViews, AreNoneWhereAllErr) {
  auto views = views_of_a_torus();
  for (std::size_t i = 0; i < views.size(); ++i) shift_view(views[i], i % 2 ? 2.0 : -2.0);
  EXPECT_THAT(contradicted(views), IsEmpty());
}

TEST(ContradictedViews, AreNotThoseThatAreMerelyNoisy) {
  auto views = views_of_a_torus();
  testing::add_range_noise(views[3], 10.0 * kNoise, 99);
  EXPECT_THAT(contradicted(views), IsEmpty());
}

TEST(ContradictedViews, AreNoneWhereNoTwoOthersMeasured) {
  auto views = views_of_a_torus();
  views.resize(2);
  shift_view(views[1], 5.0);
  EXPECT_THAT(contradicted(views), IsEmpty());
  // A copy is no second witness, wherever it is.
  views = views_of_a_torus();
  std::vector<RangeView> two = {views[0], views[1]};
  two.insert(two.end(), 4, views[0]);
  for (std::size_t i = 1; i < two.size(); ++i) shift_view(two[i], i == 1 ? 5.0 : 0.0);
  EXPECT_THAT(contradicted(two), IsEmpty());
}

TEST(UnsharedSamples, AreFarFromWhatOthersMeasured) {
  const auto views =
      testing::views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 12, 80, 50.0);
  const auto samplers = prepared(views);
  const Eigen::Vector3d axis = samplers[5].direction();
  std::vector<const ViewSampler*> others;  // That look across, or the other way.
  for (std::size_t i = 0; i < samplers.size(); ++i)
    if (samplers[i].direction().dot(axis) < 0.0) others.push_back(&samplers[i]);
  ASSERT_LT(others.size(), 11u);
  const RangeView left = value_of(unshared_samples(views[5], samplers[5], others));
  EXPECT_LT(left.sample_count(), views[5].sample_count());
  EXPECT_GT(2 * left.sample_count(), views[5].sample_count());
  others.clear();
  for (std::size_t i = 0; i < samplers.size(); ++i)
    if (i != 5) others.push_back(&samplers[i]);
  EXPECT_EQ(value_of(unshared_samples(views[5], samplers[5], others)).sample_count(), 0u);
  RangeView moved = views[5];
  shift_view(moved, 40.0);
  const ViewSampler sampler = value_of(ViewSampler::create(moved, {}));
  EXPECT_EQ(value_of(unshared_samples(moved, sampler, others)).sample_count(), 0u)
      << "its rays pass what others measured before they end";
}

}  // namespace
}  // namespace relief::fusion
