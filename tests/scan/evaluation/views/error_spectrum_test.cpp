#include "scan/evaluation/views/error_spectrum.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "scan/base/counter_random.h"

namespace relief::evaluation {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

ErrorGrid white_noise(int width, int height, double sigma, std::uint64_t seed) {
  const CounterRandom random(seed, 0);
  ErrorGrid grid(width, height);
  for (std::size_t i = 0; i < grid.size(); ++i) grid[i] = sigma * random.normal(i);
  return grid;
}

// A plane wave of variance amplitude^2 / 2.
ErrorGrid wave(int width, int height, double amplitude, double frequency, double direction) {
  ErrorGrid grid(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      grid(u, v) = amplitude * std::sin(2.0 * std::numbers::pi * frequency *
                                            (u * std::cos(direction) + v * std::sin(direction)) +
                                        0.4);
  return grid;
}

ErrorGrid sum(ErrorGrid a, const ErrorGrid& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

ErrorSpectrum spectrum_of(const ErrorGrid& grid) {
  TileSpectra spectra;
  spectra.add(grid);
  return spectra.spectrum();
}

double variance(const ErrorGrid& grid) {
  std::complex<double> mean = 0.0;
  double squares = 0.0;
  for (const auto& value : grid) mean += value, squares += std::norm(value);
  const double count = static_cast<double>(grid.size());
  return squares / count - std::norm(mean / count);
}

// Four standard deviations of the estimate, and a hundredth.
double tolerance(const SpectrumBand& band) {
  return 0.01 + 4.0 * 2.0 / (band.tile * std::sqrt(static_cast<double>(band.tiles) * band.area));
}

TEST(ErrorSpectrum, OfWhiteNoiseIsFlatAtItsVariance) {
  const double sigma = 0.3;
  const ErrorSpectrum spectrum = spectrum_of(white_noise(400, 300, sigma, 1));
  ASSERT_GT(spectrum.bands.size(), 20u);
  for (const SpectrumBand& band : spectrum.bands) {
    EXPECT_NEAR(band.density / (sigma * sigma), 1.0, tolerance(band)) << "at " << band.frequency;
  }
  EXPECT_NEAR(spectrum.bands.front().frequency, 2.0 / 256.0, 1.0 / 256.0);
  EXPECT_NEAR(spectrum.bands.back().high, std::sqrt(0.5), 1e-12);
}

TEST(ErrorSpectrum, AddsUpToTheVariance) {
  const ErrorGrid grid = sum(white_noise(512, 512, 0.2, 2), wave(512, 512, 0.5, 0.07, 0.6));
  EXPECT_NEAR(spectrum_of(grid).variance() / variance(grid), 1.0, 0.02);
}

TEST(ErrorSpectrum, OfAWaveIsOneLineOfItsPower) {
  for (const double frequency : {0.02, 0.05, 0.13, 0.31}) {
    const ErrorSpectrum spectrum = spectrum_of(wave(512, 512, 2.0, frequency, 0.3));
    double near = 0.0, all = 0.0, mean = 0.0;
    for (const SpectrumBand& band : spectrum.bands) {
      const double power = band.density * band.area;
      all += power;
      mean += power * band.frequency;
      if (band.high > frequency / 1.2 && band.low < frequency * 1.2) near += power;
    }
    EXPECT_NEAR(all, 2.0, 0.06) << frequency;
    EXPECT_GT(near, 0.98 * all) << frequency;
    EXPECT_NEAR(mean / all, frequency, 0.1 * frequency);
  }
}

TEST(ErrorSpectrum, ScalesWithTheSquareOfTheUnit) {
  ErrorGrid grid = white_noise(100, 80, 1.0, 3);
  const ErrorSpectrum before = spectrum_of(grid);
  for (auto& value : grid) value *= 1000.0;
  const ErrorSpectrum after = spectrum_of(grid);
  ASSERT_EQ(before.bands.size(), after.bands.size());
  for (std::size_t i = 0; i < before.bands.size(); ++i)
    EXPECT_NEAR(after.bands[i].density / before.bands[i].density, 1e6, 1e-3);
}

TEST(ErrorSpectrum, HasNoPlane) {
  ErrorGrid grid(200, 200);
  for (int v = 0; v < 200; ++v)
    for (int u = 0; u < 200; ++u) grid(u, v) = 1e6 + 300.0 * u - 70.0 * v;
  EXPECT_LT(spectrum_of(grid).variance(), 1e-12);
}

// A steep spectrum, as of integrated normals, with white noise of a ten thousandth of its power:
// neither the window nor the holes may carry its power to high frequencies.
TEST(ErrorSpectrum, DoesNotLeakThroughHolesOrTileBorders) {
  const double floor = 1e-2;
  ErrorGrid grid = white_noise(512, 512, floor, 4);
  for (const double frequency : {1.0 / 400.0, 1.0 / 200.0, 1.0 / 90.0})
    grid = sum(grid, wave(512, 512, 1.0, frequency, 300.0 * frequency));
  const CounterRandom random(5, 0);
  for (std::size_t i = 0; i < grid.size(); ++i)
    if (random.uniform(i) < 0.01) grid[i] = kMissing;
  for (int v = 200; v < 330; ++v)
    for (int u = 150; u < 260; ++u) grid(u, v) = kMissing;  // also a hole larger than a tile
  const ErrorSpectrum spectrum = spectrum_of(grid);
  EXPECT_LT(spectrum.coarsest_coverage, 1.0);
  for (const SpectrumBand& band : spectrum.bands) {
    if (band.low < 0.1) continue;
    EXPECT_NEAR(band.density / (floor * floor), 1.0, 0.05 + tolerance(band)) << band.frequency;
  }
}

TEST(ErrorSpectrum, FewHolesHardlyChangeWhiteNoise) {
  ErrorGrid grid = white_noise(400, 400, 1.0, 6);
  const CounterRandom random(7, 0);
  for (std::size_t i = 0; i < grid.size(); ++i)
    if (random.uniform(i) < 0.01) grid[i] = kMissing;
  for (const SpectrumBand& band : spectrum_of(grid).bands)
    EXPECT_NEAR(band.density, 1.0, 0.03 + tolerance(band)) << band.frequency;
}

// Neighbouring sums of white noise: |1 + e^(i w)|^2 = 4 cos^2(w / 2) along each axis.
TEST(ErrorSpectrum, OfSmoothedNoiseFollowsItsTransfer) {
  const ErrorGrid noise = white_noise(513, 513, 1.0, 8);
  ErrorGrid smooth(512, 512);
  for (int v = 0; v < 512; ++v)
    for (int u = 0; u < 512; ++u)
      smooth(u, v) = 0.25 * (noise(u, v) + noise(u + 1, v) + noise(u, v + 1) + noise(u + 1, v + 1));
  const auto transfer = [](double frequency) {
    double sum = 0.0;  // over directions
    for (int i = 0; i < 360; ++i) {
      const double angle = std::numbers::pi * (i + 0.5) / 360.0;
      const double x = std::numbers::pi * frequency * std::cos(angle);
      const double y = std::numbers::pi * frequency * std::sin(angle);
      sum += std::pow(std::cos(x) * std::cos(y), 2.0) / 360.0;
    }
    return sum;
  };
  for (const SpectrumBand& band : spectrum_of(smooth).bands) {
    if (band.high > 0.45) continue;  // the mean over a band is not the value at its mean
    EXPECT_NEAR(band.density / transfer(band.frequency), 1.0, 0.02 + tolerance(band));
  }
}

TEST(ErrorSpectrum, OfTwoComponentsIsTheirSum) {
  const ErrorGrid a = white_noise(128, 128, 1.0, 9), b = white_noise(128, 128, 0.5, 10);
  ErrorGrid both = a;
  for (std::size_t i = 0; i < both.size(); ++i) both[i] += std::complex(0.0, 1.0) * b[i];
  const auto of_a = spectrum_of(a), of_b = spectrum_of(b), of_both = spectrum_of(both);
  for (std::size_t i = 0; i < of_both.bands.size(); ++i)
    EXPECT_NEAR(of_both.bands[i].density, of_a.bands[i].density + of_b.bands[i].density, 1e-9);
}

TEST(ErrorSpectrum, PoolsGrids) {
  const ErrorGrid a = white_noise(64, 64, 1.0, 11), b = white_noise(200, 100, 1.0, 12);
  TileSpectra together, first, second;
  together.add(a), together.add(b);
  first.add(a), second.add(b);
  first.add(second);
  const auto expected = together.spectrum(), merged = first.spectrum();
  ASSERT_EQ(merged.bands.size(), expected.bands.size());
  for (std::size_t i = 0; i < merged.bands.size(); ++i)
    EXPECT_NEAR(merged.bands[i].density, expected.bands[i].density, 1e-12);
}

TEST(ErrorSpectrum, IsEmptyWhereNoTileFits) {
  EXPECT_TRUE(spectrum_of(white_noise(15, 300, 1.0, 13)).bands.empty());
  EXPECT_TRUE(spectrum_of(ErrorGrid(100, 100, kMissing)).bands.empty());
  EXPECT_TRUE(TileSpectra().spectrum().bands.empty());
}

TEST(CrossingFrequency, IsWhereThePowersAreEqual) {
  // Differences of white noise have 2 - 2 cos w along an axis; they reach 0.1 at cos w = 0.95.
  const ErrorGrid noise = white_noise(513, 512, 1.0, 14);
  ErrorGrid steep(512, 512);
  for (int v = 0; v < 512; ++v)
    for (int u = 0; u < 512; ++u)
      steep(u, v) = (noise(u + 1, v) - noise(u, v)) +
                    std::complex(0.0, 1.0) * (v > 0 ? noise(u, v) - noise(u, v - 1) : 0.0);
  const auto high = spectrum_of(steep),
             flat = spectrum_of(white_noise(512, 512, std::sqrt(0.1), 15));
  const auto crossing = crossing_frequency(high, flat);
  ASSERT_TRUE(crossing);
  EXPECT_NEAR(*crossing, std::acos(0.95) / (2.0 * std::numbers::pi), 0.003);
  EXPECT_FALSE(crossing_frequency(flat, high));
  EXPECT_FALSE(crossing_frequency(flat, {}));
}

}  // namespace
}  // namespace relief::evaluation
