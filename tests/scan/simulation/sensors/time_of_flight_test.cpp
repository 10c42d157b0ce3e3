#include "scan/simulation/sensors/time_of_flight.h"

#include <cmath>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "relief/simulation/range_sensors.h"
#include "tests/scan/simulation/sensor_bench.h"
#include "tests/support/result_matchers.h"

namespace relief::simulation {
namespace {

using testing::SensorBench;

TimeOfFlightCamera perfect_camera() {
  TimeOfFlightCamera camera;
  camera.noise = camera.least_amplitude = camera.flying_fraction = 0.0;
  camera.multipath = camera.range_step = 0.0;
  return camera;
}

RangeView scanned(const SensorBench& bench, const TimeOfFlightCamera& camera, int view = 0) {
  RangeView scan = bench.truth;
  scan_by_time_of_flight(scan, camera, bench.scene(view));
  return scan;
}

// Errors of the range [sample spacings] in some columns.
std::vector<double> errors(const SensorBench& bench, const RangeView& scan, int begin = 0,
                           int end = 320) {
  std::vector<double> found;
  for (int v = 0; v < scan.height(); ++v)
    for (int u = begin; u < end; ++u)
      if (scan.has_sample(u, v))
        found.push_back((scan.range(u, v) - bench.truth.range(u, v)) / bench.scene().spacing);
  return found;
}

double rms(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

TEST(TimeOfFlight, WithoutErrorsMeasuresTheTruth) {
  const SensorBench bench(testing::sphere({0, 0, 10}, 1.2));
  EXPECT_EQ(rms(errors(bench, scanned(bench, perfect_camera()))), 0.0);
}

TEST(TimeOfFlight, NoiseGrowsAsTheAmplitudeFalls) {
  TimeOfFlightCamera camera = perfect_camera();
  camera.noise = 0.5;
  const auto noise = [&](double depth, double tilt_deg) {
    const double tilt = tilt_deg * std::acos(-1.0) / 180.0;
    const SensorBench bench(testing::plane({0, 0, depth}, {std::sin(tilt), 0.0, -std::cos(tilt)}));
    return rms(errors(bench, scanned(bench, camera), 150, 170));
  };
  EXPECT_NEAR(noise(10.0, 0.0), 0.5, 0.02);
  EXPECT_NEAR(noise(14.0, 0.0), 0.5 * 1.96, 0.04);
  EXPECT_NEAR(noise(10.0, 60.0), 0.5 * 2.0, 0.06);
}

TEST(TimeOfFlight, LosesSamplesThatGiveTooLittleLightBack) {
  TimeOfFlightCamera camera = perfect_camera();
  camera.least_amplitude = 0.5;
  const SensorBench bench(testing::sphere({0, 0, 10}, 1.2));
  const RangeView scan = scanned(bench, camera);
  EXPECT_TRUE(scan.has_sample(160, 120));
  EXPECT_LT(scan.sample_count(), bench.truth.sample_count());
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      if (!scan.has_sample(u, v)) continue;
      const Eigen::Vector3d direction = bench.truth.camera.ray(u, v).direction.normalized();
      const double cosine = -bench.truth.normals(u, v).cast<double>().dot(direction);
      const double fall = 10.0 / bench.truth.range(u, v);
      EXPECT_GE(cosine * fall * fall, 0.5);
    }
  }
}

TEST(TimeOfFlight, MultipathIsSmoothNeverTooNearAndAnotherInEveryView) {
  TimeOfFlightCamera camera = perfect_camera();
  camera.multipath = 2.0;
  const SensorBench bench(testing::sphere({0, 0, 10}, 1.2));
  const RangeView first = scanned(bench, camera), second = scanned(bench, camera, 1);
  const std::vector<double> found = errors(bench, first);
  EXPECT_NEAR(rms(found), 2.0, 1e-9);
  for (const double error : found) EXPECT_GE(error, -1e-9);
  const auto error = [&](const RangeView& scan, int u) {
    return (scan.range(u, 120) - bench.truth.range(u, 120)) / bench.scene().spacing;
  };
  for (int u = 140; u < 180; ++u) EXPECT_NEAR(error(first, u), error(first, u + 1), 0.3);
  EXPECT_NE(error(first, 160), error(second, 160));
}

TEST(TimeOfFlight, RangesAreMultiplesOfTheStep) {
  TimeOfFlightCamera camera = perfect_camera();
  camera.range_step = 2.0;
  const SensorBench bench(testing::sphere({0, 0, 10}, 1.2));
  const double step = 2.0 * bench.scene().spacing;
  for (const double range : scanned(bench, camera).range)
    if (range == range) {
      EXPECT_NEAR(range / step, std::round(range / step), 1e-9);
    }
}

TEST(TimeOfFlight, SamplesAtEdgesLieBetweenTheSides) {
  TimeOfFlightCamera camera = perfect_camera();
  camera.flying_fraction = 1.0;
  const SensorBench bench([](const Ray& ray) {
    const auto near = testing::sphere({0, 0, 10}, 0.5)(ray);
    return near ? near : testing::plane({0, 0, 14}, {0, 0, -1})(ray);
  });
  const RangeView scan = scanned(bench, camera);
  int between = 0;
  for (const double range : scan.range) between += range > 10.1 && range < 13.9;
  EXPECT_GT(between, 50);
}

TEST(TimeOfFlight, DoesNotDependOnThreads) {
  const SensorBench bench(testing::sphere({0, 0, 10}, 1.2), SensorBench::default_camera(),
                          patchy_surface());
  SensorScene scene = bench.scene();
  RangeView one = bench.truth, three = bench.truth;
  on_threads(1, [&] { scan_by_time_of_flight(one, {}, scene); });
  on_threads(3, [&] { scan_by_time_of_flight(three, {}, scene); });
  EXPECT_EQ(std::memcmp(one.range.data(), three.range.data(), 8 * one.range.size()), 0);
}

TEST(TimeOfFlight, NamesAFieldOutOfItsRange) {
  TimeOfFlightCamera camera;
  camera.multipath_wavelength = 0.0;
  EXPECT_THAT(validate(camera), HasError("multipath_wavelength"));
}

}  // namespace
}  // namespace relief::simulation
