// Merging views with samples missing at random and with flying samples.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "relief/fusion/merge_views.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

const testing::SignedDistance kTorus = testing::torus_distance(35.0, 12.0);

std::vector<RangeView> noisy_views() {
  std::vector<RangeView> views = testing::views_around(testing::traced(kTorus), 12, 90, 50.0);
  std::uint32_t seed = 1;
  for (RangeView& view : views) testing::add_range_noise(view, 0.2, seed++);
  return views;
}

template <typename Change>
void for_some(RangeView& view, double part, const Change& change) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (std::size_t i = 0; i < view.range.size(); ++i) {
    const double draw = chance(generator), size = normal(generator);
    if (draw < part && view.range[i] == view.range[i]) change(i, size);
  }
}

struct Outcome {
  double rms = 0.0, filled_area = 0.0;
  std::size_t flying = 0, filled = 0;
};

Outcome outcome_of(const std::vector<RangeView>& views) {
  const auto result = value_of(merge_views(views));
  EXPECT_EQ(result.check.genus, 1);
  double squares = 0.0, count = 0.0;
  for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
    if (result.mesh.filled[v]) continue;
    squares += std::pow(kTorus(result.mesh.vertices[v]), 2);
    count += 1.0;
  }
  return {std::sqrt(squares / count), result.filled_area_fraction, result.flying_samples,
          result.filled_samples};
}

TEST(IncompleteViews, MissingSamplesCostLittle) {
  std::vector<RangeView> views = noisy_views();
  const Outcome clean = outcome_of(views);
  for (RangeView& view : views) {
    for_some(view, 0.15, [&](std::size_t i, double) {
      view.range[i] = kNoSample;
      view.normals[i].setConstant(static_cast<float>(kNoSample));
    });
  }
  const Outcome spoiled = outcome_of(views);
  EXPECT_LT(spoiled.rms, 1.3 * clean.rms);
  EXPECT_LT(spoiled.filled_area, clean.filled_area + 0.01);
  EXPECT_GT(spoiled.filled, 1000u);
}

TEST(IncompleteViews, FlyingSamplesAreLeftOut) {
  std::vector<RangeView> views = noisy_views();
  const Outcome clean = outcome_of(views);
  for (RangeView& view : views)
    for_some(view, 0.02, [&](std::size_t i, double size) { view.range[i] += 15.0 * size; });
  const Outcome spoiled = outcome_of(views);
  EXPECT_GT(spoiled.flying, clean.flying + 100);
  EXPECT_LT(spoiled.rms, 1.3 * clean.rms);
  EXPECT_LT(spoiled.filled_area, clean.filled_area + 0.01);
}

}  // namespace
}  // namespace relief::fusion
