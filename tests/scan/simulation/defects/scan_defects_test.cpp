#include "relief/simulation/scan_defects.h"

#include <cmath>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "relief/simulation/simulate.h"
#include "scan/simulation/defects/scan_defects.h"
#include "tests/support/result_matchers.h"

namespace relief::simulation {
namespace {

SimulationOptions exact_sensors() {
  SimulationOptions options;
  options.views = 3;
  options.width = options.height = 128;
  options.mesh_divisions = 0;
  options.pose = PoseKind::kKnown;
  options.range_sensor = WhiteRangeSensor{0.0};
  options.normal_sensor = WhiteNormalSensor{0.0, 0.0};
  return options;
}

Simulation simulated(const SimulationOptions& options) { return value_of(simulate(options)); }

// The errors of the range [sample spacings] of all samples that the truth has.
std::vector<double> range_errors(const Simulation& simulation, std::size_t index,
                                 int first_column = 0, int end_column = 1 << 20) {
  const RangeView& scan = simulation.scans.views[index];
  const RangeView& truth = simulation.truth.views[index];
  std::vector<double> errors;
  for (int v = 0; v < scan.height(); ++v)
    for (int u = first_column; u < std::min(end_column, scan.width()); ++u)
      if (scan.has_sample(u, v) && truth.has_sample(u, v))
        errors.push_back((scan.range(u, v) - truth.range(u, v)) / simulation.spacing);
  return errors;
}

double rms(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

bool same_bytes(const RangeView& a, const RangeView& b) {
  return std::memcmp(a.range.data(), b.range.data(), a.range.size() * sizeof(double)) == 0 &&
         std::memcmp(a.normals.data(), b.normals.data(),
                     a.normals.size() * sizeof(Eigen::Vector3f)) == 0;
}

TEST(ScanDefects, LosesTheStatedPartOfTheSamplesWithTheirNormals) {
  SimulationOptions options = exact_sensors();
  options.defects.missing_fraction = 0.15;
  const Simulation simulation = simulated(options);
  for (std::size_t i = 0; i < 3; ++i) {
    const RangeView &scan = simulation.scans.views[i], &truth = simulation.truth.views[i];
    const double all = static_cast<double>(truth.sample_count());
    EXPECT_NEAR(static_cast<double>(scan.sample_count()) / all, 0.85, 4 * std::sqrt(0.1275 / all));
    for (int v = 0; v < scan.height(); ++v)
      for (int u = 0; u < scan.width(); ++u)
        EXPECT_EQ(scan.has_sample(u, v), scan.has_normal(u, v));
  }
}

TEST(ScanDefects, RoundsRangesToSteps) {
  SimulationOptions options = exact_sensors();
  options.defects.quantisation = 4.0;
  const Simulation simulation = simulated(options);
  const double step = 4.0 * simulation.spacing;
  for (const double range : simulation.scans.views[1].range)
    if (range == range) {
      EXPECT_NEAR(range / step, std::round(range / step), 1e-9);
    }
  EXPECT_NEAR(rms(range_errors(simulation, 1)), 4.0 / std::sqrt(12.0), 0.05);
}

TEST(ScanDefects, WarpsEveryViewInAnotherWay) {
  SimulationOptions options = exact_sensors();
  options.defects.view_warp = 0.5;
  const Simulation simulation = simulated(options);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(rms(range_errors(simulation, i)), 0.5, 1e-9) << i;
  // The same pixels err differently; neighbours err alike.
  const auto error = [&](std::size_t i, int u, int v) {
    return simulation.scans.views[i].range(u, v) - simulation.truth.views[i].range(u, v);
  };
  EXPECT_GT(std::abs(error(0, 64, 64) - error(1, 64, 64)), 0.01 * simulation.spacing);
  EXPECT_NEAR(error(0, 64, 64), error(0, 65, 64), 0.1 * simulation.spacing);
}

TEST(ScanDefects, RaisesTheNoiseOfOneHalf) {
  SimulationOptions options = exact_sensors();
  options.range_sensor = WhiteRangeSensor{0.3};
  options.defects.noise_half = 5.0;
  const Simulation simulation = simulated(options);
  EXPECT_NEAR(rms(range_errors(simulation, 0, 0, 64)), 0.3, 0.02);
  EXPECT_NEAR(rms(range_errors(simulation, 0, 64)), 1.5, 0.1);

  options.range_sensor = structured_light_scanner();
  const Simulation scanner = simulated(options);
  options.defects.noise_half = 1.0;
  const Simulation even = simulated(options);
  EXPECT_EQ(range_errors(scanner, 0, 0, 64), range_errors(even, 0, 0, 64));
  EXPECT_GT(rms(range_errors(scanner, 0, 64)), 1.3 * rms(range_errors(even, 0, 64)));
}

TEST(ScanDefects, ThrowsTheStatedPartOfTheSamplesOff) {
  SimulationOptions options = exact_sensors();
  options.defects.outlier_fraction = 0.02;
  const Simulation simulation = simulated(options);
  std::vector<double> off;
  const std::vector<double> errors = range_errors(simulation, 0);
  for (const double error : errors)
    if (error != 0.0) off.push_back(error);
  const double all = static_cast<double>(errors.size());
  EXPECT_NEAR(static_cast<double>(off.size()) / all, 0.02, 4 * std::sqrt(0.0196 / all));
  EXPECT_NEAR(rms(off), 20.0, 5.0);
}

TEST(ScanDefects, PutsAPlateBehindTheObjectThatStandsStillBeforeTheSensor) {
  SimulationOptions options = exact_sensors();
  options.defects.background = BackgroundPlate{};
  const Simulation simulation = simulated(options);
  const Simulation bare = simulated(exact_sensors());
  const RangeView &first = simulation.scans.views[0], &second = simulation.scans.views[1];
  std::size_t plate = 0, both = 0;
  for (int v = 0; v < first.height(); ++v) {
    for (int u = 0; u < first.width(); ++u) {
      if (simulation.truth.views[0].has_sample(u, v)) {
        EXPECT_EQ(first.range(u, v), bare.scans.views[0].range(u, v));
        continue;
      }
      if (!first.has_sample(u, v)) continue;
      ++plate;
      EXPECT_GT(first.range(u, v), simulation.distance);
      EXPECT_NEAR(first.normals(u, v).z(), -std::cos(20.0 * std::acos(-1.0) / 180.0), 1e-6);
      if (!second.has_sample(u, v) || simulation.truth.views[1].has_sample(u, v)) continue;
      ++both;
      EXPECT_NEAR(first.range(u, v), second.range(u, v), 1e-9);
    }
  }
  EXPECT_GT(plate, 4000u);
  EXPECT_GT(both, 4000u);
  EXPECT_TRUE(same_bytes(simulation.truth.views[0], bare.truth.views[0]));
}

TEST(ScanDefects, SensorsErrOnThePlateToo) {
  SimulationOptions options = exact_sensors();
  options.defects.background = BackgroundPlate{};
  const Simulation exact = simulated(options);
  options.range_sensor = structured_light_scanner();
  options.normal_sensor = PhotometricStereo{};
  options.reflectance = patchy_surface();
  const Simulation measured = simulated(options);
  const RangeView &a = exact.scans.views[0], &b = measured.scans.views[0];
  double differing = 0.0, both = 0.0, lost = 0.0;
  for (std::size_t i = 0; i < a.range.size(); ++i) {
    if (a.range[i] != a.range[i] || exact.truth.views[0].range[i] == exact.truth.views[0].range[i])
      continue;
    if (b.range[i] != b.range[i]) {
      lost += 1.0;
      continue;
    }
    both += 1.0;
    differing += a.range[i] != b.range[i];
  }
  EXPECT_GT(both, 3000.0);
  EXPECT_GT(lost, 10.0);  // The shadow of the object.
  EXPECT_GT(differing, 0.9 * both);
}

TEST(ScanDefects, TurnsNormalsIntoAnotherConvention) {
  SimulationOptions options = exact_sensors();
  const Simulation right = simulated(options);
  const auto normal = [&](NormalMistake mistake) {
    options.defects.normal_mistake = mistake;
    return simulated(options).scans.views[1].normals(60, 64);
  };
  const Eigen::Vector3f n = right.scans.views[1].normals(60, 64);
  EXPECT_EQ(normal(NormalMistake::kFlipX), Eigen::Vector3f(-n.x(), n.y(), n.z()));
  EXPECT_EQ(normal(NormalMistake::kFlipY), Eigen::Vector3f(n.x(), -n.y(), n.z()));
  EXPECT_EQ(normal(NormalMistake::kFlipZ), Eigen::Vector3f(n.x(), n.y(), -n.z()));
  EXPECT_EQ(normal(NormalMistake::kSwapXY), Eigen::Vector3f(n.y(), n.x(), n.z()));
  const Eigen::Vector3d world = right.truth.views[1].world_from_view.linear() * n.cast<double>();
  EXPECT_LT((normal(NormalMistake::kWorldSpace).cast<double>() - world).norm(), 1e-6);
}

TEST(ScanDefects, StatesAWrongFocalLengthAndScale) {
  SimulationOptions options = exact_sensors();
  options.defects.focal_factor = 1.005;
  options.defects.scale_factor = 0.99;
  const Simulation simulation = simulated(options);
  const RangeView &scan = simulation.scans.views[0], &truth = simulation.truth.views[0];
  EXPECT_DOUBLE_EQ(scan.camera.intrinsics().fx, 1.005 * truth.camera.intrinsics().fx);
  EXPECT_DOUBLE_EQ(scan.camera.intrinsics().fy, 1.005 * truth.camera.intrinsics().fy);
  EXPECT_NEAR(scan.range(64, 64), 0.99 * truth.range(64, 64), 1e-9);
  options.rays = SensorRays::kLine;
  EXPECT_THAT(simulate(options), HasError("focal_factor"));
}

TEST(ScanDefects, HidesADistortionOfTheLensAndAnOffset) {
  SimulationOptions options = exact_sensors();
  const Simulation right = simulated(options);
  options.defects.radial_distortion = 0.01;
  options.defects.range_offset = 2.0;
  const Simulation wrong = simulated(options);
  const RangeView &scan = wrong.scans.views[0], &truth = wrong.truth.views[0];
  EXPECT_EQ(scan.camera.ray(3, 5).direction, right.scans.views[0].camera.ray(3, 5).direction);
  const Eigen::Vector3d stated = scan.camera.ray(0, 0).direction;
  const Eigen::Vector3d farther = truth.camera.ray(0, 0).direction;
  EXPECT_NEAR(farther.x(), 1.01 * stated.x(), 1e-12);
  EXPECT_NEAR(farther.y(), 1.01 * stated.y(), 1e-12);
  const double length = scan.camera.ray(64, 64).direction.norm();
  EXPECT_NEAR((scan.range(64, 64) - truth.range(64, 64)) * length, 2.0 * wrong.spacing, 1e-9);
  options.rays = SensorRays::kLine;
  EXPECT_THAT(simulate(options), HasError("radial_distortion"));
}

TEST(ScanDefects, DoNotDependOnThreads) {
  SimulationOptions options = exact_sensors();
  options.range_sensor = WhiteRangeSensor{0.3};
  options.defects.background = BackgroundPlate{};
  options.defects.noise_half = 3.0;
  options.defects.view_warp = 0.5;
  options.defects.outlier_fraction = 0.02;
  options.defects.quantisation = 2.0;
  options.defects.missing_fraction = 0.1;
  const auto simulated_on = [&](int threads) {
    return on_threads(threads, [&] { return simulated(options); });
  };
  const Simulation one = simulated_on(1), three = simulated_on(3);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_TRUE(same_bytes(one.scans.views[i], three.scans.views[i]));
}

TEST(ScanDefects, NamesAFieldOutOfItsRange) {
  ScanDefects defects;
  EXPECT_THAT(validate(defects), IsOk());
  defects.missing_fraction = 1.0;
  EXPECT_THAT(validate(defects), HasError("missing_fraction"));
  defects = {};
  defects.background = BackgroundPlate{0.51, 20.0};
  EXPECT_THAT(validate(defects), HasError("background distance"));
  defects = {};
  defects.noise_half = 0.0;
  EXPECT_THAT(validate(defects), HasError("noise_half"));
}

}  // namespace
}  // namespace relief::simulation
