#include "scan/simulation/defects/calibration_warp.h"

#include <cmath>

#include <gtest/gtest.h>

namespace relief::simulation {
namespace {

TEST(CalibrationWarp, HasMeanZeroAndUnitRmsOverTheImage) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const CalibrationWarp warp({seed, 9});
    constexpr int kCount = 200;
    double sum = 0.0, squares = 0.0;
    for (int j = 0; j < kCount; ++j) {
      for (int i = 0; i < kCount; ++i) {
        const double value = warp.at((2 * i + 1.0) / kCount - 1.0, (2 * j + 1.0) / kCount - 1.0);
        sum += value / (kCount * kCount);
        squares += value * value / (kCount * kCount);
      }
    }
    EXPECT_NEAR(sum, 0.0, 1e-3);
    EXPECT_NEAR(squares, 1.0, 1e-3);
  }
}

// Fourth differences of a cubic vanish.
TEST(CalibrationWarp, IsACubicAlongAnyLine) {
  const CalibrationWarp warp({3, 9});
  const double x = -0.7, y = 0.2, dx = 0.3, dy = -0.2;
  double difference = 0.0;
  const double weights[] = {1, -4, 6, -4, 1};
  for (int k = 0; k < 5; ++k) difference += weights[k] * warp.at(x + k * dx, y + k * dy);
  EXPECT_NEAR(difference, 0.0, 1e-12);
}

}  // namespace
}  // namespace relief::simulation
