#include "hybrid/noise/noise.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/hybrid/bumpy_view.h"
#include "tests/support/degree.h"

namespace relief::hybrid {
namespace {

using testing::kDegree;

const RangeView& truth() {
  static const RangeView view =
      testing::render(testing::bumpy_surface(), testing::bumpy_camera(200, 160));
  return view;
}

struct Noise {
  double range, normal_deg, bias_deg;
};

NoiseEstimate estimate_of(const RangeView& view) {
  return estimate_noise(view, connect_samples(view));
}

RangeView noisy(const Noise& noise) {
  RangeView view = truth();
  testing::add_range_noise(view, noise.range, 11);
  testing::add_normal_noise(view, noise.normal_deg * kDegree, 12);
  testing::add_normal_bias(view, noise.bias_deg * kDegree);
  return view;
}

TEST(Noise, IsFoundOverTheWholeRangeOfInterest) {
  for (const double range : {0.05, 0.2, 1.0}) {
    for (const double normal : {0.3, 1.5, 5.0}) {
      for (const double bias : {0.0, 4.0}) {
        const NoiseEstimate estimate = estimate_of(noisy({range, normal, bias}));
        EXPECT_NEAR(estimate.sigma_position / range, 1.0, 0.1)
            << range << " " << normal << " " << bias;
        EXPECT_NEAR(estimate.sigma_normal / (normal * kDegree), 1.0, 0.1)
            << range << " " << normal << " " << bias;
      }
    }
  }
}

TEST(Noise, ScalesWithTheUnit) {
  RangeView view = noisy({0.3, 1.5, 4.0});
  const NoiseEstimate a = estimate_of(view);
  for (double& t : view.range) t *= 0.001;
  const NoiseEstimate b = estimate_of(view);
  EXPECT_NEAR(b.sigma_position, 0.001 * a.sigma_position, 1e-5 * a.sigma_position);
  EXPECT_NEAR(b.sigma_normal, a.sigma_normal, 1e-4 * a.sigma_normal);
}

TEST(Noise, QuantisedRangesAreNoPuzzle) {
  RangeView view = noisy({0.1, 1.5, 0.0});
  const double quantum = 0.2;
  for (double& t : view.range) t = quantum * std::round(t / quantum);
  // Rounding adds a uniform error.
  const double expected = std::sqrt(0.1 * 0.1 + quantum * quantum / 12.0);
  EXPECT_NEAR(estimate_of(view).sigma_position / expected, 1.0, 0.15);
}

TEST(Noise, WildSamplesAndOcclusionsDoNotInflateIt) {
  RangeView view = noisy({0.2, 1.5, 0.0});
  for (std::size_t i = 0; i < view.range.size(); i += 37) view.range[i] += 5.0;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 120; u < view.width(); ++u) view.range(u, v) += 30.0;
  EXPECT_NEAR(estimate_of(view).sigma_position / 0.2, 1.0, 0.15);
  testing::add_normal_outliers(view, 0.03, 5);
  const NoiseEstimate estimate = estimate_of(view);
  EXPECT_NEAR(estimate.sigma_local / 0.2, 1.0, 0.15);
  EXPECT_NEAR(estimate.sigma_normal / (1.5 * kDegree), 1.0, 0.15);
}

TEST(Noise, RangesThatErrAlikeCountForWhatTheyDoOverLongWaves) {
  for (const int size : {3, 5}) {
    for (const double bias_deg : {0.0, 4.0}) {
      RangeView view = truth();
      testing::add_smoothed_range_noise(view, 1.0, size, 11);
      testing::add_normal_noise(view, 1.5 * kDegree, 12);
      testing::add_normal_bias(view, bias_deg * kDegree);
      const NoiseEstimate estimate = estimate_of(view);
      EXPECT_NEAR(estimate.sigma_local, 1.0 / size, 0.5 / size) << size << " " << bias_deg;
      EXPECT_GT(estimate.sigma_position, 0.5) << size << " " << bias_deg;
      EXPECT_LT(estimate.sigma_position, 1.1) << size << " " << bias_deg;
    }
  }
}

TEST(Noise, NothingIsEstimatedFromAHandfulOfSamples) {
  RangeView view = testing::render(testing::bumpy_surface(), testing::bumpy_camera(4, 3));
  EXPECT_FALSE(estimate_of(view).usable());
  view.normals = {};
  EXPECT_FALSE(estimate_of(view).usable());
}

TEST(Noise, TheBiasOfTheNormalsIsSeen) {
  EXPECT_LT(estimate_of(noisy({0.2, 1.5, 0.0})).bias, 0.7 * kDegree);
  const double bias = estimate_of(noisy({0.2, 1.5, 4.0})).bias;
  EXPECT_GT(bias, 2.5 * kDegree);
  EXPECT_LT(bias, 7.0 * kDegree);
}

}  // namespace
}  // namespace relief::hybrid
