#include "relief/reconstruction/cross_view_consistency.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::reconstruction {
namespace {

constexpr double kRadius = 50.0, kDistance = 200.0;
constexpr double kNoise = 0.15;  // About 0.3 sample spacings of a view of 96 pixels.
constexpr int kSize = 96;

Camera camera_of(int size) {
  return Camera::pinhole(size, size, {4.0 * size, 4.0 * size, 0.5 * size, 0.5 * size});
}

RangeView view_from(double angle_deg, std::uint32_t seed, int size = kSize) {
  const double angle = angle_deg * M_PI / 180.0;
  const Eigen::Vector3d eye(kDistance * std::sin(angle), -kDistance * std::cos(angle), 0.0);
  RangeView view = render(testing::sphere(Eigen::Vector3d::Zero(), kRadius), camera_of(size),
                          testing::look_at(eye, Eigen::Vector3d::Zero()));
  view.name = "v" + std::to_string(seed);
  view.pose = PoseKind::kGuess;
  testing::add_range_noise(view, kNoise, seed);
  return view;
}

std::vector<RangeView> views_from(const std::vector<double>& angles_deg) {
  std::vector<RangeView> views;
  for (const double angle : angles_deg)
    views.push_back(view_from(angle, 1 + static_cast<std::uint32_t>(views.size())));
  return views;
}

std::vector<registration::PairFit> all_pairs(std::size_t count) {
  std::vector<registration::PairFit> pairs;
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count; ++b) {
      pairs.emplace_back();
      pairs.back().a = a;
      pairs.back().b = b;
    }
  }
  return pairs;
}

// A disc of radius 8 pixels in the middle of the image; its range is wrong by waves of 3 spacings.
bool in_patch(int u, int v) { return std::hypot(u - kSize / 2, v - kSize / 2) < 8.0; }

void spoil_patch(RangeView& view) {
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (in_patch(u, v) && view.has_sample(u, v))
        view.range(u, v) += 1.5 * std::sin(0.9 * u + 0.4 * v);
}

std::vector<ViewConsistency> weigh(std::vector<RangeView>& views, int threads = 2) {
  return value_of(weigh_by_consistency(all_pairs(views.size()), {}, views, {.threads = threads}));
}

double mean_confidence(const RangeView& view, bool inside) {
  double sum = 0.0, count = 0.0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v) || in_patch(u, v) != inside) continue;
      sum += view.confidence_at(u, v);
      count += 1.0;
    }
  }
  return sum / count;
}

TEST(CrossViewConsistency, LeavesNoiseAlone) {
  std::vector<RangeView> views = views_from({-30, -15, 0, 15, 30});
  for (const ViewConsistency& view : weigh(views)) {
    EXPECT_GT(view.compared, 2000u);
    EXPECT_EQ(view.contradicted, 0u);
    EXPECT_GT(view.deviation, 0.7 * kNoise);
    EXPECT_LT(view.deviation, 1.5 * kNoise);
  }
  for (const RangeView& view : views) EXPECT_TRUE(view.confidence.empty());
}

TEST(CrossViewConsistency, LowersTheConfidenceOfAWrongPatchOnly) {
  std::vector<RangeView> views = views_from({-30, -15, 0, 15, 30});
  spoil_patch(views[2]);
  const auto found = weigh(views);
  EXPECT_GT(found[2].contradicted, 150u);
  EXPECT_LT(mean_confidence(views[2], true), 0.25);
  EXPECT_GT(mean_confidence(views[2], false), 0.98);
  for (const std::size_t other : {0u, 1u, 3u, 4u})
    EXPECT_LT(found[other].contradicted, found[other].compared / 50) << other;
}

double rms_in_patch(const RangeView& view, const RangeView& truth) {
  double sum = 0.0, count = 0.0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!in_patch(u, v)) continue;
      sum += std::pow(view.range(u, v) - truth.range(u, v), 2);
      count += 1.0;
    }
  }
  return std::sqrt(sum / count);
}

TEST(CrossViewConsistency, CorrectsRangesThatStandApart) {
  const RangeView truth = view_from(0, 0);  // Of another seed: with noise of its own.
  std::vector<RangeView> views = views_from({-30, -15, 0, 15, 30});
  const RangeView good = views[2];
  spoil_patch(views[2]);
  const RangeView spoiled = views[2];
  std::vector<RangeView> weighed = views;
  const auto found = weigh(views);
  EXPECT_GT(found[2].corrected, 50u);
  EXPECT_LE(found[2].corrected, found[2].contradicted);
  EXPECT_LT(rms_in_patch(views[2], truth), 0.5 * rms_in_patch(spoiled, truth));
  for (int v = 0; v < kSize; ++v)
    for (int u = 0; u < kSize; ++u)
      if (std::hypot(u - kSize / 2, v - kSize / 2) > 12.0 && good.has_sample(u, v)) {
        EXPECT_EQ(views[2].range(u, v), good.range(u, v));
      }
  ASSERT_TRUE(weigh_by_consistency(all_pairs(5), {.correct = false}, weighed));
  EXPECT_EQ(rms_in_patch(weighed[2], truth), rms_in_patch(spoiled, truth));
}

TEST(CrossViewConsistency, OneOtherViewDoesNotDecide) {
  std::vector<RangeView> views = views_from({-10, 10});
  spoil_patch(views[0]);
  for (const ViewConsistency& view : weigh(views)) {
    EXPECT_EQ(view.compared, 0u);
    EXPECT_EQ(view.contradicted, 0u);
  }
}

TEST(CrossViewConsistency, ViewsOutsideOfThePairsSayNothing) {
  std::vector<RangeView> views = views_from({-20, 0, 20});
  spoil_patch(views[1]);
  const auto found = weigh_by_consistency({all_pairs(3)[0]}, {}, views);
  ASSERT_TRUE(found);
  EXPECT_EQ((*found)[1].compared, 0u);
}

TEST(CrossViewConsistency, CoarseViewsDoNotContradictAFineOne) {
  std::vector<RangeView> views = views_from({-20, 0, 20});
  views[0] = view_from(-20, 1, kSize / 3);
  views[2] = view_from(20, 3, kSize / 3);
  spoil_patch(views[1]);
  const ViewConsistency found = weigh(views)[1];
  EXPECT_LT(found.compared, views[1].sample_count() / 20);  // Only where it is steep itself.
  EXPECT_EQ(found.contradicted, 0u);
}

TEST(CrossViewConsistency, ASmoothErrorOfAWholeViewIsNoContradiction) {
  std::vector<RangeView> views = views_from({-30, -15, 0, 15, 30});
  for (double& range : views[2].range) range += 1.0;
  EXPECT_EQ(weigh(views)[2].contradicted, 0u);
}

TEST(CrossViewConsistency, RaisesDeviationsByAsMuch) {
  std::vector<RangeView> views = views_from({-30, -15, 0, 15, 30});
  spoil_patch(views[2]);
  views[2].deviation = {kSize, kSize, 0.5f};
  weigh(views);
  const float confidence = views[2].confidence(kSize / 2, kSize / 2);
  ASSERT_LT(confidence, 1.0f);
  EXPECT_FLOAT_EQ(views[2].deviation(kSize / 2, kSize / 2), 0.5f / std::sqrt(confidence));
}

TEST(CrossViewConsistency, DoesNotDependOnThreadsAndHardlyOnTheFrame) {
  std::vector<RangeView> views = views_from({-30, -15, 0, 15, 30});
  spoil_patch(views[2]);
  std::vector<RangeView> one = views, turned = views;
  const RigidMotion motion(Eigen::Translation3d(300.0, -20.0, 7.0) *
                           Eigen::AngleAxisd(1.0, Eigen::Vector3d(1, 2, 3).normalized()));
  for (RangeView& view : turned) view.world_from_view = motion * view.world_from_view;
  const auto found = weigh(views, 3);
  weigh(one, 1);
  const auto elsewhere = weigh(turned);
  EXPECT_TRUE(std::equal(views[2].confidence.begin(), views[2].confidence.end(),
                         one[2].confidence.begin()));
  EXPECT_NEAR(static_cast<double>(elsewhere[2].contradicted),
              static_cast<double>(found[2].contradicted), 2.0);
  EXPECT_NEAR(elsewhere[2].deviation, found[2].deviation, 1e-6);
}

TEST(CrossViewConsistency, StopsOnRequest) {
  std::vector<RangeView> views = views_from({-15, 0, 15});
  spoil_patch(views[1]);
  const auto stopped = weigh_by_consistency(
      all_pairs(3), {}, views, {.progress = [](double, std::string_view) { return false; }});
  EXPECT_THAT(stopped, HasError(ErrorKind::kInterrupted));
  EXPECT_TRUE(views[1].confidence.empty());
}

}  // namespace
}  // namespace relief::reconstruction
