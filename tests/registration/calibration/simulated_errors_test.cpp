// Errors of the camera of simulated scans, found from the scans alone.

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "relief/registration/calibrate_views.h"
#include "relief/simulation/simulate.h"

namespace relief::registration {
namespace {

simulation::SimulationOptions small_scans() {
  simulation::SimulationOptions options;
  options.views = 10;
  options.width = options.height = 160;
  options.mesh_divisions = 0;
  return options;
}

SensorCalibration calibration_of(const std::vector<RangeView>& views) {
  return calibrate_views(views, align_views(views).value()).value();
}

TEST(SimulatedErrors, FindsAFocalLengthThatIsTooLong) {
  simulation::SimulationOptions options = small_scans();
  options.defects.focal_factor = 1.005;
  auto views = simulation::simulate(options).value().scans.views;
  const double given = views[0].camera.intrinsics().fx;
  const SensorCalibration calibration = calibration_of(views);
  apply_calibration(calibration, views);
  ASSERT_EQ(calibration.errors.size(), 1u);
  EXPECT_EQ(calibration.errors[0].error, SensorError::kFocalLength);
  EXPECT_FALSE(calibration.errors[0].per_view);
  // Views of 160 pixels: three quarters of the error are found, and all of it at 512
  // (docs/results.md).
  EXPECT_NEAR(views[0].camera.intrinsics().fx / given, 1.0 / 1.005, 0.005 / 3.0);
  ASSERT_EQ(calibration.notes.size(), 1u);
  EXPECT_NE(calibration.notes[0].find("the focal length is too long"), std::string::npos)
      << calibration.notes[0];
}

TEST(SimulatedErrors, FindsADistortionOfTheLens) {
  simulation::SimulationOptions options = small_scans();
  options.defects.radial_distortion = 0.03;
  const SensorCalibration calibration =
      calibration_of(simulation::simulate(options).value().scans.views);
  ASSERT_EQ(calibration.errors.size(), 1u);
  EXPECT_EQ(calibration.errors[0].error, SensorError::kRadialDistortion);
  EXPECT_FALSE(calibration.errors[0].per_view);
}

TEST(SimulatedErrors, FindsNothingInCleanScans) {
  EXPECT_FALSE(calibration_of(simulation::simulate(small_scans()).value().scans.views).found());
}

// The size of everything cannot be seen by one sensor: the ranges stay.
TEST(SimulatedErrors, LeavesTheOverallScale) {
  simulation::SimulationOptions options = small_scans();
  options.defects.scale_factor = 1.02;
  for (const CalibratedError& error :
       calibration_of(simulation::simulate(options).value().scans.views).errors)
    EXPECT_FALSE(error.error == SensorError::kRangeScale && !error.per_view);
}

}  // namespace
}  // namespace relief::registration
