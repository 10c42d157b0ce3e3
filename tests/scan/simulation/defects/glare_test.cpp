#include "scan/simulation/defects/glare.h"

#include <cmath>

#include <gtest/gtest.h>

#include "relief/simulation/scan_defects.h"
#include "scan/simulation/defects/scan_defects.h"
#include "tests/scan/simulation/sensor_bench.h"
#include "tests/support/result_matchers.h"

namespace relief::simulation {
namespace {

using testing::SensorBench;

constexpr double kPi = 3.14159265358979323846;

// Of a sphere, whose highlights lie where its normal is the half vector.
struct Spoiled {
  explicit Spoiled(const Glare& glare, int view = 0)
      : bench(testing::sphere({0, 0, 10}, 1.5)), scan(bench.truth) {
    add_glare(scan, glare, bench.scene(view));
  }
  // Angle between the exact normal and the axis towards the sensor [degrees].
  double inclination(int u, int v) const {
    return std::acos(-bench.truth.normals(u, v).z()) * 180.0 / kPi;
  }
  SensorBench bench;
  RangeView scan;
};

TEST(Glare, SpoilsRangeAndNormalsOfTheHighlightsOnly) {
  Glare glare;
  const Spoiled spoiled(glare);
  double squares = 0.0, inside = 0.0, turned = 0.0, spoilt = 0.0;
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      if (!spoiled.bench.truth.has_sample(u, v)) continue;
      const double error = (spoiled.scan.range(u, v) - spoiled.bench.truth.range(u, v)) /
                           spoiled.bench.scene().spacing;
      const double angle =
          testing::angle_between(spoiled.scan.normals(u, v), spoiled.bench.truth.normals(u, v));
      spoilt += std::abs(error) > 0.05;
      // Half vectors lie half of 30 degrees off the axis; three widths away nothing is left.
      if (std::abs(spoiled.inclination(u, v) - 15.0) > 25.0) {
        EXPECT_NEAR(error, 0.0, 0.01);
        EXPECT_LT(angle, 1e-3);
      }
      if (angle * 180.0 / kPi < 13.0) continue;
      squares += error * error;
      inside += 1.0;
      turned = std::max(turned, angle * 180.0 / kPi);
    }
  }
  EXPECT_GT(inside, 20.0);
  EXPECT_NEAR(std::sqrt(squares / inside), 3.0, 1.5);
  EXPECT_NEAR(turned, 15.0, 3.0);  // towards the lamp
  EXPECT_LT(spoilt, 0.2 * static_cast<double>(spoiled.bench.truth.sample_count()));
}

TEST(Glare, LeavesExactRangesWithoutARangeError) {
  Glare glare;
  glare.range_error = 0.0;
  const Spoiled spoiled(glare);
  for (std::size_t i = 0; i < spoiled.scan.range.size(); ++i)
    if (spoiled.scan.range[i] == spoiled.scan.range[i]) {
      EXPECT_EQ(spoiled.scan.range[i], spoiled.bench.truth.range[i]);
    }
}

TEST(Glare, NamesAFieldOutOfItsRange) {
  Glare glare;
  glare.lamps = 0;
  EXPECT_THAT(validate(glare), HasError("glare lamps"));
}

}  // namespace
}  // namespace relief::simulation
