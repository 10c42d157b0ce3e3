#include "scan/simulation/sensors/pixel_noise.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "tests/support/parameter_names.h"

namespace relief::simulation {
namespace {

double correlation(const Grid<double>& noise, int du, int dv) {
  double sum = 0.0, count = 0.0;
  for (int v = 0; v + dv < noise.height(); ++v)
    for (int u = 0; u + du < noise.width(); ++u, count += 1.0)
      sum += noise(u, v) * noise(u + du, v + dv);
  return sum / count;
}

class PixelNoiseOfLength : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Lengths, PixelNoiseOfLength, ::testing::Values(1.5, 2.0, 3.0, 6.0),
                         testing::PrintedName());

TEST_P(PixelNoiseOfLength, HasTheStatedVarianceAndCorrelation) {
  const double length = GetParam();
  const Grid<double> noise = pixel_noise(700, 600, length, {3, 1});
  // The number of independent patches bounds how well the moments are known.
  const double tolerance = 4.0 * length * std::sqrt(4.0 / static_cast<double>(noise.size()));
  EXPECT_NEAR(correlation(noise, 0, 0), 1.0, tolerance);
  for (const auto& [du, dv] : {std::pair{1, 0}, {0, 1}, {2, 0}, {0, 3}, {2, 2}, {6, 1}}) {
    const double expected = std::exp(-(du * du + dv * dv) / (length * length));
    EXPECT_NEAR(correlation(noise, du, dv), expected, tolerance) << du << dv;
  }
}

TEST(PixelNoise, IsWhiteWithoutCorrelation) {
  const Grid<double> noise = pixel_noise(500, 400, 0.0, {4, 2});
  EXPECT_NEAR(correlation(noise, 0, 0), 1.0, 0.015);
  EXPECT_NEAR(correlation(noise, 1, 0), 0.0, 0.01);
  EXPECT_NEAR(correlation(noise, 0, 1), 0.0, 0.01);
}

TEST(PixelNoise, IsAsRandomAtTheBorder) {
  double squares = 0.0;
  constexpr int kFields = 40;
  for (std::uint64_t field = 0; field < kFields; ++field) {
    const Grid<double> noise = pixel_noise(200, 8, 3.0, {5, field});
    for (int u = 0; u < 200; ++u) squares += noise(u, 0) * noise(u, 0) / (200.0 * kFields);
  }
  EXPECT_NEAR(squares, 1.0, 0.08);
}

TEST(PixelNoise, DoesNotDependOnThreads) {
  const auto noise_on = [](int threads) {
    return on_threads(threads, [] { return pixel_noise(130, 70, 2.5, {6, 7}); });
  };
  const Grid<double> one = noise_on(1);
  for (const int threads : {2, 4}) {
    const Grid<double> other = noise_on(threads);
    EXPECT_EQ(std::memcmp(one.data(), other.data(), one.size() * sizeof(double)), 0);
  }
}

}  // namespace
}  // namespace relief::simulation
