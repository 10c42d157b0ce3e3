// What refine_view does with the errors of real sensors, with default options.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "relief/hybrid/refine_view.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

using testing::kDegree;
constexpr int kSide = 160;

const RangeView& truth() {
  static const RangeView view =
      testing::render(testing::bumpy_surface(), testing::bumpy_camera(kSide, kSide));
  return view;
}

RangeView measured(double range_noise = 0.3) {
  RangeView view = truth();
  testing::add_range_noise(view, range_noise, 1);
  testing::add_normal_noise(view, 1.5 * kDegree, 2);
  testing::add_normal_bias(view, 4.0 * kDegree);
  return view;
}

RefinedView refined(const RangeView& view) { return value_of(refine_view(view)); }

// Over the samples that both have.
double depth_rms(const RangeView& view) {
  double squares = 0.0, count = 0.0;
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      if (!view.has_sample(u, v)) continue;
      const double length = view.camera.ray(u, v).direction.norm();
      squares += std::pow(length * (view.range(u, v) - truth().range(u, v)), 2);
      count += 1.0;
    }
  }
  return std::sqrt(squares / count);
}

double clean_rms() {
  static const double rms = depth_rms(refined(measured()).view);
  return rms;
}

template <typename Change>
void for_some(RangeView& view, double part, const Change& change) {
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (std::size_t i = 0; i < view.range.size(); ++i) {
    const double draw = chance(generator), size = normal(generator);
    if (draw < part) change(i, size);
  }
}

TEST(RealNoise, MissingSamplesCostLittle) {
  RangeView view = measured();
  for_some(view, 0.15, [&](std::size_t i, double) {
    view.range[i] = kNoSample;
    view.normals[i].setConstant(static_cast<float>(kNoSample));
  });
  const RefinedView result = refined(view);
  EXPECT_EQ(result.status, RefineStatus::kRefined);
  EXPECT_GT(result.filled, 0.14 * kSide * kSide);
  EXPECT_NEAR(result.sigma_position, 0.3, 0.02);
  EXPECT_LT(depth_rms(result.view), 1.3 * clean_rms());
}

TEST(RealNoise, FilledSamplesAreNoMoreCertainThanMeasuredOnes) {
  RangeView view = measured();
  for_some(view, 0.15, [&](std::size_t i, double) { view.range[i] = kNoSample; });
  const RefinedView result = refined(view);
  double filled = 0.0, kept = 0.0, filled_count = 0.0, kept_count = 0.0;
  for (std::size_t i = 0; i < view.range.size(); ++i) {
    if (!(result.view.deviation[i] > 0.0f)) continue;
    const bool was_measured = view.range[i] == view.range[i];
    (was_measured ? kept : filled) += result.view.deviation[i];
    (was_measured ? kept_count : filled_count) += 1.0;
  }
  EXPECT_GE(filled / filled_count, 0.99 * kept / kept_count);
}

TEST(RealNoise, FlyingSamplesAreTakenAway) {
  RangeView view = measured();
  for_some(view, 0.02, [&](std::size_t i, double size) { view.range[i] += 20.0 * size; });
  const RefinedView result = refined(view);
  EXPECT_EQ(result.status, RefineStatus::kRefined);
  EXPECT_GT(result.flying, 0.01 * kSide * kSide);
  EXPECT_LT(depth_rms(result.view), 1.3 * clean_rms());
}

TEST(RealNoise, SamplesThatAreWrongByLittleFollowTheirNormals) {
  RangeView view = measured();
  for_some(view, 0.02, [&](std::size_t i, double size) {
    if (std::abs(size) < 1.0) view.range[i] += size < 0.0 ? -1.8 : 1.8;
  });
  EXPECT_LT(depth_rms(refined(view).view), 1.2 * clean_rms());
}

TEST(RealNoise, RoundedRangesAreRefined) {
  for (const double step : {1.0, 2.0, 4.0}) {
    RangeView view = measured();
    for (double& t : view.range) t = step * std::round(t / step);
    const RefinedView result = refined(view);
    EXPECT_EQ(result.status, RefineStatus::kRefined) << step;
    EXPECT_GE(result.sigma_position, 0.999 * step / std::sqrt(12.0)) << step;
    EXPECT_LT(depth_rms(result.view), 0.35 * depth_rms(view)) << step;
  }
}

TEST(RealNoise, NoiseMayChangeOverTheView) {
  RangeView view = measured();
  const RangeView loud = measured(1.5);
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide / 2; ++u) view.range(u, v) = loud.range(u, v);
  const RefinedView result = refined(view);
  EXPECT_EQ(result.status, RefineStatus::kRefined);
  // The loud half as if all were, the quiet one as if all were.
  RangeView left = result.view, right = result.view;
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u) (u < kSide / 2 ? right : left).range(u, v) = kNoSample;
  EXPECT_LT(depth_rms(left), 1.2 * depth_rms(refined(loud).view));
  EXPECT_LT(depth_rms(right), 1.4 * clean_rms());
  // Deviations tell the halves apart.
  EXPECT_GT(result.view.deviation(20, kSide / 2),
            1.5 * result.view.deviation(kSide - 20, kSide / 2));
}

TEST(RealNoise, NothingIsRefinedThatGetsWorse) {
  int contradictions = 0;
  for (const double noise : {0.02, 0.05, 0.1, 0.3}) {
    for (const auto& [x, y] : {std::pair{1.0f, -1.0f}, {-1.0f, 1.0f}, {-1.0f, -1.0f}}) {
      RangeView view = measured(noise);
      for (auto& normal : view.normals) normal = {x * normal.x(), y * normal.y(), normal.z()};
      const RefinedView result = refined(view);
      const double before = depth_rms(view), after = depth_rms(result.view);
      EXPECT_LE(after, 1.001 * before) << noise << " " << x << " " << y;
      if (result.status != RefineStatus::kContradiction) continue;
      EXPECT_EQ(after, before);
      ++contradictions;
    }
  }
  EXPECT_GT(contradictions, 0);
}

}  // namespace
}  // namespace relief::hybrid
