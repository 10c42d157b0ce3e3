#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "relief/evaluation/view_errors.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::evaluation {
namespace {

ScanProject project_of(const RangeView& view) {
  ScanProject project;
  project.views = {view};
  project.views[0].name = "a";
  return project;
}

RangeView flat_view(int size = 256) {
  const Camera camera =
      Camera::orthographic(size, size, {0, 0, 0}, {0.05, 0, 0}, {0, 0.05, 0}, {0, 0, 2});
  return testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), camera);
}

const SpectrumBand& band_at(const ErrorSpectrum& spectrum, double frequency) {
  for (const SpectrumBand& band : spectrum.bands)
    if (band.low <= frequency && frequency < band.high) return band;
  ADD_FAILURE() << "no band at " << frequency;
  return spectrum.bands.front();
}

// White noise s of the depth gives central differences of power s^2 (sin^2 wu + sin^2 wv) /
// spacing^2; independent rotations r about two axes give 2 r^2. At low frequencies they cross where
// (s w / spacing)^2 = 2 r^2.
TEST(EvaluateSpectra, ShowWhereNormalMapsAreBetter) {
  const double s = 0.002, r = 0.01, spacing = 0.05;
  const RangeView truth = flat_view();
  RangeView noisy = truth;
  testing::add_range_noise(noisy, s, 3);
  testing::add_normal_noise(noisy, r, 4);
  const auto spectra = value_of(evaluate_spectra(project_of(noisy), project_of(truth)));
  for (const double frequency : {0.05, 0.1, 0.2, 0.4}) {
    EXPECT_NEAR(band_at(spectra.depth, frequency).density / (s * s), 1.0, 0.12) << frequency;
    EXPECT_NEAR(band_at(spectra.map_normals, frequency).density / (2.0 * r * r), 1.0, 0.12);
  }
  const SpectrumBand& low = band_at(spectra.position_normals, 0.05);
  const double slope = 2.0 * std::numbers::pi * low.frequency * s / spacing;
  EXPECT_NEAR(low.density / (slope * slope), 1.0, 0.15);
  EXPECT_NEAR(spectra.spacing, spacing, 1e-9);
  ASSERT_TRUE(spectra.crossing_wavelength);
  const double expected = 2.0 * std::numbers::pi * s / spacing / (std::sqrt(2.0) * r);
  EXPECT_NEAR(*spectra.crossing_wavelength, expected, 0.1 * expected);
}

TEST(EvaluateSpectra, OfTheTruthAreZero) {
  const auto spectra =
      value_of(evaluate_spectra(project_of(flat_view(64)), project_of(flat_view(64))));
  EXPECT_FALSE(spectra.depth.bands.empty());
  EXPECT_EQ(spectra.depth.variance(), 0.0);
  EXPECT_EQ(spectra.position_normals.variance(), 0.0);
  EXPECT_FALSE(spectra.crossing_wavelength);
}

TEST(EvaluateSpectra, DoNotDependOnThreadsOrUnit) {
  const RangeView truth = flat_view(100);
  ScanProject truths, noisy;
  for (const char* name : {"a", "b", "c"}) {
    truths.views.push_back(truth);
    truths.views.back().name = name;
    noisy.views.push_back(truths.views.back());
    testing::add_range_noise(noisy.views.back(), 0.002, static_cast<std::uint32_t>(name[0]));
  }
  const auto one = evaluate_spectra(noisy, truths, {}, {.threads = 1});
  const auto three = evaluate_spectra(noisy, truths, {}, {.threads = 3});
  ASSERT_TRUE(one && three);
  EXPECT_EQ(one->depth.variance(), three->depth.variance());
  EXPECT_EQ(one->position_normals.variance(), three->position_normals.variance());
}

TEST(EvaluateSpectra, NeedATrueViewOfTheName) {
  ScanProject other = project_of(flat_view(64));
  other.views[0].name = "b";
  EXPECT_FALSE(evaluate_spectra(project_of(flat_view(64)), other));
}

}  // namespace
}  // namespace relief::evaluation
