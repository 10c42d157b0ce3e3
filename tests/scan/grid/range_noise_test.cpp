#include "scan/grid/range_noise.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

constexpr int kSide = 256;

// Sample spacing about 1.
const Camera kPinhole = Camera::pinhole(kSide, kSide, {400.0, 400.0, 127.5, 127.5});

RangeView tilted_plane() {
  return testing::render(testing::plane({0, 0, 400}, {0.23, 0.11, 1}), kPinhole);
}
RangeView ball() { return testing::render(testing::sphere({0, 0, 400}, 110.0), kPinhole); }

void round_ranges(RangeView& view, double step) {
  for (double& t : view.range) t = step * std::round(t / step);
}

void round_inverse_ranges(RangeView& view, double step) {
  for (double& t : view.range) t = 1.0 / (step * std::round(1.0 / (t * step)));
}

void lose_samples(RangeView& view, double part, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  for (double& t : view.range)
    if (chance(generator) < part) t = kNoSample;
}

void through_single_precision(RangeView& view) {
  for (double& t : view.range) t = static_cast<double>(static_cast<float>(t));
}

TEST(RangeQuantisation, FindsStepsOfTheRange) {
  for (const double step : {0.05, 0.5, 2.0, 4.0}) {
    for (RangeView view : {tilted_plane(), ball()}) {
      testing::add_range_noise(view, 0.3, 5);
      round_ranges(view, step);
      through_single_precision(view);
      const RangeQuantisation found = find_quantisation(view);
      EXPECT_NEAR(found.step, step, 1e-3 * step);
      EXPECT_EQ(found.inverse_step, 0.0) << step;
    }
  }
}

TEST(RangeQuantisation, FindsStepsOfTheInverseRange) {
  // Of 0.5, 2 and 4 units at a range of 400, written in steps of 0.1 or not at all.
  for (const double at_400 : {0.5, 2.0, 4.0}) {
    for (const double written : {0.0, 0.1}) {
      RangeView view = tilted_plane();
      testing::add_range_noise(view, 0.3, 5);
      const double step = at_400 / (400.0 * 400.0);
      round_inverse_ranges(view, step);
      if (written > 0.0) round_ranges(view, written);
      through_single_precision(view);
      const RangeQuantisation found = find_quantisation(view);
      // Closer steps are not told from rounding.
      if (at_400 < 10.0 * written) continue;
      EXPECT_NEAR(found.inverse_step, step, 0.01 * step) << at_400 << " " << written;
      EXPECT_NEAR(found.step_at(400.0, 1.0), at_400, 0.02 * at_400);
    }
  }
}

// The view as another camera a fraction of a pixel aside would have it: by bilinear interpolation.
void shift_by_interpolation(RangeView& view, double du, double dv) {
  const RangeView before = view;
  for (int v = 0; v + 1 < view.height(); ++v) {
    for (int u = 0; u + 1 < view.width(); ++u) {
      if (!before.has_sample(u, v) || !before.has_sample(u + 1, v) ||
          !before.has_sample(u, v + 1) || !before.has_sample(u + 1, v + 1)) {
        view.range(u, v) = kNoSample;
        continue;
      }
      const double upper = std::lerp(before.range(u, v), before.range(u + 1, v), du);
      const double lower = std::lerp(before.range(u, v + 1), before.range(u + 1, v + 1), du);
      view.range(u, v) = std::lerp(upper, lower, dv);
    }
  }
}

TEST(RangeQuantisation, FindsStepsOfInterpolatedMaps) {
  constexpr double at_400 = 4.0, step = at_400 / (400.0 * 400.0);
  for (RangeView view : {tilted_plane(), ball()}) {
    testing::add_range_noise(view, 0.05, 5);
    round_inverse_ranges(view, step);
    shift_by_interpolation(view, 0.37, 0.58);
    round_ranges(view, 0.1);
    const RangeQuantisation found = find_quantisation(view);
    EXPECT_NEAR(found.inverse_step, step, 0.02 * step);
    constexpr double nearest = 290.0;
    EXPECT_GE(estimate_range_noise(view).sigma, step * nearest * nearest / std::sqrt(12.0));
  }
}

// A slab that leans along the columns, so that each row is a run, with a raised stroke.
TEST(RangeQuantisation, FindsNoneWhereRowsAreRuns) {
  RangeView view = testing::render(testing::plane({0, 0, 400}, {0, 0.2, 1}), kPinhole);
  for (int v = 40; v < 200; ++v)
    for (int u = 60; u < 120; ++u) view.range(u, v) *= 0.995;
  for (int v = 40; v < 200; ++v)
    for (int u = 90; u < 120; ++u) view.range(u, v) *= 0.995;
  EXPECT_FALSE(find_quantisation(view).exists());
}

TEST(RangeQuantisation, FindsNoneBetweenRunsOfEnlargedMaps) {
  // Each sample four times: runs that differ by anything.
  RangeView view = ball();
  testing::add_range_noise(view, 1.0, 5);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u) view.range(u, v) = view.range(u / 4 * 4, v / 4 * 4);
  EXPECT_FALSE(find_quantisation(view).exists());
}

TEST(RangeQuantisation, FindsStepsWhereSamplesAreMissingOrFly) {
  RangeView view = ball();
  testing::add_range_noise(view, 0.3, 5);
  round_ranges(view, 2.0);
  lose_samples(view, 0.15, 3);
  for (std::size_t i = 0; i < view.range.size(); i += 50) view.range[i] += 19.7;
  EXPECT_NEAR(find_quantisation(view).step, 2.0, 2e-3);
}

TEST(RangeQuantisation, FindsNoneInPlainMeasurements) {
  for (const double noise : {0.0, 1e-4, 0.3, 3.0}) {
    for (RangeView view : {tilted_plane(), ball()}) {
      testing::add_range_noise(view, noise, 5);
      EXPECT_FALSE(find_quantisation(view).exists()) << noise;
      through_single_precision(view);
      EXPECT_FALSE(find_quantisation(view).exists()) << noise;
    }
  }
}

TEST(RangeQuantisation, FindsNoneOnExactPlanes) {
  const Camera camera = Camera::orthographic(60, 50, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  for (const double slope : {0.0, 1.0, 12.0})
    EXPECT_FALSE(
        find_quantisation(testing::render(testing::plane({0, 0, 100}, {slope, 0, 1}), camera))
            .exists())
        << slope;
}

TEST(RangeNoise, IsThatOfTheSamples) {
  for (const double sigma : {0.05, 0.3, 1.0, 3.0, 8.0}) {
    for (RangeView view : {tilted_plane(), ball()}) {
      testing::add_range_noise(view, sigma, 5);
      const RangeNoise noise = estimate_range_noise(view);
      EXPECT_NEAR(noise.sigma, sigma, 0.05 * sigma);
    }
  }
}

TEST(RangeNoise, IsTheSameEverywhereWhereTheSamplesAre) {
  for (const double sigma : {0.1, 1.0}) {
    RangeView view = tilted_plane();
    testing::add_range_noise(view, sigma, 5);
    EXPECT_TRUE(estimate_range_noise(view).map.empty()) << sigma;
  }
}

TEST(RangeNoise, IsNeverBelowWhatRoundingLeaves) {
  for (const double step : {0.5, 2.0, 4.0}) {
    RangeView view = tilted_plane();
    testing::add_range_noise(view, 0.02, 5);
    round_ranges(view, step);
    const RangeNoise noise = estimate_range_noise(view);
    for (int v = 0; v < kSide; v += 5)
      for (int u = 0; u < kSide; u += 5)
        EXPECT_GE(noise.sigma_at(u, v), 0.999 * step / std::sqrt(12.0));
    EXPECT_LE(noise.sigma, 0.6 * step);
  }
}

// As a scanner's steps of z that were moved to other rays: none is exact, and zeros are rounding.
TEST(RangeNoise, IsNotTheRoundingOfRangesThatWereRoundedOnOtherRays) {
  RangeView view = testing::render(testing::plane({0, 0, 400}, {0.02, 0.01, 1}), kPinhole);
  for (int v = 0; v < kSide; ++v) {
    const double step = 0.8 + 0.2 * v / kSide;  // Along the row.
    for (int u = 0; u < kSide; ++u) view.range(u, v) = step * std::round(view.range(u, v) / step);
  }
  testing::add_range_noise(view, 1e-6, 3);
  const RangeNoise noise = estimate_range_noise(view);
  EXPECT_GT(noise.sigma, 0.05);
  EXPECT_LT(noise.sigma, 0.8);
}

TEST(RangeNoise, IsMappedWhereItChanges) {
  RangeView quiet = ball(), loud = ball();
  testing::add_range_noise(quiet, 0.1, 5);
  testing::add_range_noise(loud, 0.5, 6);
  RangeView view = quiet;
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide / 2; ++u) view.range(u, v) = loud.range(u, v);
  const RangeNoise noise = estimate_range_noise(view);
  ASSERT_FALSE(noise.map.empty());
  for (int v = 64; v < kSide - 64; v += 8) {
    EXPECT_NEAR(noise.sigma_at(kSide / 2 - 24, v), 0.5, 0.2);
    EXPECT_NEAR(noise.sigma_at(kSide / 2 + 24, v), 0.1, 0.04);
  }
  EXPECT_NE(describe(noise, view, "mm").find("times larger at the left than at the right"),
            std::string::npos)
      << describe(noise, view, "mm");
}

TEST(RangeNoise, WithstandsMissingAndFlyingSamples) {
  for (const double lost : {0.0, 0.15, 0.5}) {
    RangeView view = ball();
    testing::add_range_noise(view, 0.3, 5);
    lose_samples(view, lost, 3);
    for (std::size_t i = 0; i < view.range.size(); i += 50) view.range[i] += 20.0;
    EXPECT_NEAR(estimate_range_noise(view).sigma, 0.3, 0.03) << lost;
  }
}

TEST(RangeNoise, IsSeenWhereTheSensorInterpolatesAlongOneDirection) {
  RangeView view = tilted_plane();
  testing::add_range_noise(view, 0.3, 5);
  for (int v = 0; v + 4 < kSide; v += 4)
    for (int u = 0; u < kSide; ++u)
      for (int k = 1; k < 4; ++k)
        view.range(u, v + k) = std::lerp(view.range(u, v), view.range(u, v + 4), 0.25 * k);
  const double sigma = estimate_range_noise(view).sigma;
  EXPECT_GT(sigma, 0.1);
  EXPECT_LT(sigma, 0.35);
}

// Of large views only some of the differences are used.
class LargeView : public ::testing::Test {
 protected:
  static constexpr int kWidth = 1280, kHeight = 160;
  const RangeView exact_ =
      testing::render(testing::plane({0, 0, 2000}, {0.23, 0.11, 1}),
                      Camera::pinhole(kWidth, kHeight, {2000.0, 2000.0, 639.5, 79.5}));

  RangeView with_noise(double sigma, std::uint32_t seed) const {
    RangeView view = exact_;
    testing::add_range_noise(view, sigma, seed);
    return view;
  }

  // Of the left and of the right half.
  RangeView with_noises(double left, double right) const {
    RangeView view = with_noise(right, 5);
    const RangeView other = with_noise(left, 6);
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth / 2; ++u) view.range(u, v) = other.range(u, v);
    return view;
  }
};

TEST_F(LargeView, HasTheNoiseOfItsSamples) {
  const RangeNoise noise = estimate_range_noise(with_noise(0.3, 5));
  EXPECT_NEAR(noise.sigma, 0.3, 0.01);
  EXPECT_TRUE(noise.map.empty());
  EXPECT_LT(noise.differences, exact_.sample_count() / 8);
}

TEST_F(LargeView, HasAMapWhereTheNoiseChangesByAThird) {
  const RangeNoise noise = estimate_range_noise(with_noises(0.3, 0.4));
  ASSERT_FALSE(noise.map.empty());
  EXPECT_NEAR(noise.sigma_at(kWidth / 4, kHeight / 2), 0.3, 0.05);
  EXPECT_NEAR(noise.sigma_at(3 * kWidth / 4, kHeight / 2), 0.4, 0.05);
}

// A fifth of the samples missing at random leaves 0.8^9 of the squares.
TEST_F(LargeView, HasAMapWhereSamplesAreMissing) {
  RangeView view = with_noises(0.3, 0.6);
  std::mt19937 random(7);
  for (double& range : view.range)
    if (random() % 5 == 0) range = kNoSample;
  const RangeNoise noise = estimate_range_noise(view);
  ASSERT_FALSE(noise.map.empty());
  EXPECT_NEAR(noise.sigma_at(kWidth / 4, kHeight / 2), 0.3, 0.06);
  EXPECT_NEAR(noise.sigma_at(3 * kWidth / 4, kHeight / 2), 0.6, 0.12);
}

TEST_F(LargeView, ShowsItsNoiseWhereEverySecondRowIsInterpolated) {
  RangeView view = with_noise(0.3, 5);
  for (int v = 1; v + 1 < kHeight; v += 2)
    for (int u = 0; u < kWidth; ++u)
      view.range(u, v) = 0.5 * (view.range(u, v - 1) + view.range(u, v + 1));
  const double sigma = estimate_range_noise(view).sigma;
  EXPECT_GT(sigma, 0.1);
  EXPECT_LT(sigma, 0.35);
}

TEST(RangeNoise, IsUnknownWithoutNeighbours) {
  RangeView view = tilted_plane();
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u)
      if (u % 2 || v % 2) view.range(u, v) = kNoSample;
  EXPECT_FALSE(estimate_range_noise(view).known());
  EXPECT_EQ(describe(estimate_range_noise(view), view, ""), "noise unknown");
}

TEST(RangeNoise, IsTheSameForAnyNumberOfThreads) {
  RangeView view = ball();
  testing::add_range_noise(view, 0.3, 5);
  for (int v = 0; v < kSide; ++v) view.range(v, 100 + v / 4) += 1.0;
  const auto noise_on = [&](int threads) {
    return on_threads(threads, [&] { return estimate_range_noise(view); });
  };
  const RangeNoise one = noise_on(1), four = noise_on(4);
  EXPECT_EQ(one.sigma, four.sigma);
  EXPECT_TRUE(std::equal(one.map.begin(), one.map.end(), four.map.begin(), four.map.end()));
}

TEST(RangeNoise, NamesTheStep) {
  RangeView view = tilted_plane();
  testing::add_range_noise(view, 0.3, 5);
  round_ranges(view, 1.0);
  const std::string words = describe(estimate_range_noise(view), view, "mm");
  EXPECT_EQ(words.find("range in steps of 1 mm; noise 0."), 0u) << words;
}

}  // namespace
}  // namespace relief
