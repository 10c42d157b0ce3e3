#include "hybrid/noise/deviation_spectrum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/hybrid/refine_view.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"

namespace relief::hybrid {
namespace {

using testing::kDegree;

constexpr double kRangeNoise = 0.2;

const RangeView& truth() {
  static const RangeView view =
      testing::render(testing::bumpy_surface(), testing::bumpy_camera(240, 200));
  return view;
}

RangeView noisy(double normal_deg, double bias_deg) {
  RangeView view = truth();
  testing::add_range_noise(view, kRangeNoise, 11);
  if (normal_deg > 0.0) testing::add_normal_noise(view, normal_deg * kDegree, 12);
  if (bias_deg > 0.0) testing::add_normal_bias(view, bias_deg * kDegree);
  return view;
}

std::vector<DeviationBand> spectrum_of(const RangeView& view, const Grid<float>& moved) {
  return deviation_spectrum(range_steps(view, connect_samples(view)), moved);
}

Grid<float> still() { return Grid<float>(truth().width(), truth().height(), 0.0f); }

// Independent noise is the same at all wavelengths, and gone where the samples moved to the truth.
TEST(DeviationSpectrum, OfWhiteNoiseIsItsDeviation) {
  const RangeView view = noisy(0.0, 0.0);
  Grid<float> moved = still();
  for (std::size_t i = 0; i < moved.size(); ++i)
    if (view.range[i] == view.range[i])
      moved[i] = static_cast<float>(truth().range[i] - view.range[i]);
  const auto bands = spectrum_of(view, moved);
  ASSERT_GE(bands.size(), 5u);
  EXPECT_EQ(bands.front().wavelength, 2.0);
  EXPECT_EQ(bands[4].wavelength, 32.0);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(bands[k].measured, kRangeNoise, 0.1 * kRangeNoise) << k;
    EXPECT_LT(bands[k].refined, 0.3 * kRangeNoise) << k;
  }
}

TEST(DeviationSpectrum, ShowsTheBiasOfNormalsAtLongWaves) {
  const auto plain = spectrum_of(noisy(0.0, 0.0), still());
  const auto biased = spectrum_of(noisy(0.0, 3.0), still());
  ASSERT_EQ(plain.size(), biased.size());
  EXPECT_NEAR(biased[0].measured, plain[0].measured, 0.05 * plain[0].measured);
  EXPECT_GT(biased.back().measured, 3.0 * plain.back().measured);
  for (const DeviationBand& band : biased) EXPECT_EQ(band.refined, band.measured);
}

TEST(DeviationSpectrum, NeedsEnoughSamples) {
  const RangeView small = testing::render(testing::bumpy_surface(), testing::bumpy_camera(12, 12));
  EXPECT_THAT(
      deviation_spectrum(range_steps(small, connect_samples(small)), Grid<float>(12, 12, 0.0f)),
      ::testing::IsEmpty());
}

TEST(DeviationSpectrum, TellsWhatRefiningDid) {
  const auto refined = value_of(refine_view(noisy(1.0, 3.0)));
  ASSERT_EQ(refined.status, RefineStatus::kRefined);
  const auto& bands = refined.spectrum;
  ASSERT_GE(bands.size(), 5u);
  EXPECT_NEAR(bands.front().measured, kRangeNoise, 0.1 * kRangeNoise);
  EXPECT_LT(bands.front().refined, 0.3 * bands.front().measured);
  // Over long waves refined ranges are the measured ones, whatever the normals say.
  EXPECT_NEAR(bands.back().refined, bands.back().measured, 0.1 * bands.back().measured);
  RangeView bare = noisy(1.0, 3.0);
  bare.normals = {};
  EXPECT_THAT(value_of(refine_view(bare)).spectrum, ::testing::IsEmpty());
}

}  // namespace
}  // namespace relief::hybrid
