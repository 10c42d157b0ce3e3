#include "scan/simulation/base/plane_waves.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace relief::simulation {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

TEST(PlaneWaves, HaveNoPowerAboveTheirHighestFrequency) {
  const double wavelength = 3.0;
  constexpr int kSamples = 1024;
  const double length = 64.0 * wavelength;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const PlaneWaves field(wavelength, CounterRandom(seed, 1));
    // A Hann window keeps the power of one wave within two lines of the spectrum.
    std::vector<double> values;
    for (int i = 0; i < kSamples; ++i)
      values.push_back((1.0 - std::cos(kTurn * i / kSamples)) *
                       field.scalar_at({length * i / kSamples, 0.4 * length * i / kSamples, 1.0}));
    const double line_length = length * std::hypot(1.0, 0.4);
    double inside = 0.0, outside = 0.0;
    for (int k = 0; k <= kSamples / 2; ++k) {
      std::complex<double> sum = 0.0;
      for (int i = 0; i < kSamples; ++i)
        sum += values[static_cast<std::size_t>(i)] * std::polar(1.0, -kTurn * i * k / kSamples);
      (k / line_length <= 1.0 / wavelength + 3.0 / line_length ? inside : outside) +=
          std::norm(sum);
    }
    EXPECT_GT(inside, 0.0);
    EXPECT_LT(outside, 1e-4 * inside);
  }
}

// The Laplacian multiplies a wave of length l by -(2 pi / l)^2.
TEST(PlaneWaves, HaveWavelengthsUpToTwiceTheShortest) {
  const double wavelength = 3.0, h = 1e-3;
  const PlaneWaves field(wavelength, CounterRandom(5, 2));
  double values = 0.0, laplacians = 0.0, count = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p(std::fmod(7.31 * i, 400.0), std::fmod(3.77 * i, 500.0), 0.013 * i);
    double laplacian = -6.0 * field.scalar_at(p);
    for (int k = 0; k < 3; ++k)
      laplacian += field.scalar_at(p + h * Eigen::Vector3d::Unit(k)) +
                   field.scalar_at(p - h * Eigen::Vector3d::Unit(k));
    values += field.scalar_at(p) * field.scalar_at(p);
    laplacians += std::pow(laplacian / (h * h), 2);
    count += 1.0;
  }
  const double ratio = std::sqrt(laplacians / values);
  EXPECT_GT(ratio, std::pow(kTurn / (2.0 * wavelength), 2));
  EXPECT_LT(ratio, std::pow(kTurn / wavelength, 2));
  EXPECT_NEAR(values / count, field.scalar_variance(), 0.03 * field.scalar_variance());
}

}  // namespace
}  // namespace relief::simulation
