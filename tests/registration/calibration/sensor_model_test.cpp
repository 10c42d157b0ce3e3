#include "registration/calibration/model/sensor_model.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/calibration/calibration_notes.h"
#include "registration/calibration/model/error_model.h"

namespace relief::registration {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kPixels = 60;
constexpr double kDistance = 300.0;

enum class Rays { kPinhole, kPinholeGl, kTable, kSpherical };

Camera camera_with(Rays rays) {
  const PinholeIntrinsics intrinsics{170.0, 165.0, 29.0, 30.5};
  switch (rays) {
    case Rays::kPinhole:
      return Camera::pinhole(kPixels, kPixels, intrinsics);
    case Rays::kPinholeGl:
      return Camera::pinhole_gl(kPixels, kPixels, intrinsics);
    case Rays::kTable: {
      Grid<Ray> table(kPixels, kPixels);
      const Camera of = Camera::orthographic(kPixels, kPixels, {-50, -50, 0}, {1.7, 0, 0},
                                             {0, 1.7, 0}, {0.1, 0.0, 1.0});
      for (int v = 0; v < kPixels; ++v)
        for (int u = 0; u < kPixels; ++u) table(u, v) = of.ray(u, v);
      return Camera::ray_table(table, std::nullopt);
    }
    case Rays::kSpherical:
      break;
  }
  return Camera::spherical(SphericalProjection::even(kPixels, kPixels, -0.17, 0.006, -0.17, 0.006));
}

// Ranges of a smooth surface.
RangeView view_with(Rays rays) {
  RangeView view;
  view.camera = camera_with(rays);
  view.range = {kPixels, kPixels, kNoSample};
  for (int v = 0; v < kPixels; ++v)
    for (int u = 0; u < kPixels; ++u)
      view.range(u, v) = kDistance + 0.02 * (u - 20) * (u - 20) + 0.3 * v;
  return view;
}

class SensorModelFields : public ::testing::TestWithParam<Rays> {};

// (C1): what a correction by a small coefficient moves every sample by, against its field.
TEST_P(SensorModelFields, AreWhatCorrectionsMoveSamplesBy) {
  const RangeView view = view_with(GetParam());
  const SensorModel model({&view}, 1.7);
  constexpr double kSmall = 1e-4;
  for (std::size_t k = 0; k < model.terms(); ++k) {
    std::vector<double> coefficients(model.terms(), 0.0), fields(model.terms());
    coefficients[k] = kSmall;
    const RangeView moved = model.corrected(view, coefficients);
    for (const auto& [u, v] : {std::pair{10, 12}, {31, 7}, {44, 51}, {29, 30}}) {
      const Eigen::Vector3d step = (moved.point(u, v) - view.point(u, v)) / kSmall;
      for (int axis = 0; axis < 3; ++axis) {
        model.project(view, Eigen::Vector2d(u, v), view.range(u, v), Eigen::Vector3d::Unit(axis),
                      fields);
        EXPECT_NEAR(step[axis], fields[k], 2e-3)
            << to_string(model.error_of(k)) << ", term " << k << ", pixel " << u << " " << v;
      }
    }
  }
}

TEST_P(SensorModelFields, MoveSamplesByOneSpacing) {
  const RangeView view = view_with(GetParam());
  const SensorModel model({&view}, 1.7);
  std::vector<double> squares(model.terms(), 0.0), fields(model.terms());
  for (int v = 0; v < kPixels; ++v)
    for (int u = 0; u < kPixels; ++u)
      for (int axis = 0; axis < 3; ++axis) {
        model.project(view, Eigen::Vector2d(u, v), view.range(u, v), Eigen::Vector3d::Unit(axis),
                      fields);
        for (std::size_t k = 0; k < fields.size(); ++k) squares[k] += fields[k] * fields[k];
      }
  // Every fourth row and column of 60 stands for all: polynomials of degree 4 are steep at the rim.
  for (std::size_t k = 0; k < squares.size(); ++k)
    EXPECT_NEAR(std::sqrt(squares[k] / (kPixels * kPixels)), 1.7, 0.5)
        << to_string(model.error_of(k)) << ", term " << k;
}

TEST_P(SensorModelFields, AreNothingWithoutCoefficients) {
  const RangeView view = view_with(GetParam());
  const SensorModel model({&view}, 1.7);
  const RangeView same = model.corrected(view, std::vector<double>(model.terms(), 0.0));
  EXPECT_TRUE(std::equal(same.range.begin(), same.range.end(), view.range.begin()));
  EXPECT_EQ(same.camera.model(), view.camera.model());
}

std::string name_of(const ::testing::TestParamInfo<Rays>& rays) {
  switch (rays.param) {
    case Rays::kPinhole:
      return "Pinhole";
    case Rays::kPinholeGl:
      return "PinholeGl";
    case Rays::kTable:
      return "TableOfRays";
    case Rays::kSpherical:
      return "Spherical";
  }
  return "Unknown";
}
INSTANTIATE_TEST_SUITE_P(Cameras, SensorModelFields,
                         ::testing::Values(Rays::kPinhole, Rays::kPinholeGl, Rays::kTable,
                                           Rays::kSpherical),
                         name_of);

TEST(SensorModel, KeepsAPinholeCameraOneWithoutDistortion) {
  const RangeView view = view_with(Rays::kPinhole);
  const SensorModel model({&view}, 1.7);
  for (std::size_t k = 0; k < model.terms(); ++k) {
    std::vector<double> coefficients(model.terms(), 0.0);
    coefficients[k] = 0.01;
    const bool distorts = model.error_of(k) == SensorError::kRadialDistortion ||
                          model.error_of(k) == SensorError::kTangentialDistortion;
    const RangeView corrected = model.corrected(view, coefficients);
    EXPECT_EQ(corrected.camera.model(),
              distorts ? Camera::Model::kRayTable : Camera::Model::kPinhole);
    EXPECT_TRUE(corrected.camera.can_project());
  }
}

TEST(CalibrationNotes, TellThePixelsOfAPrincipalPoint) {
  const RangeView view = view_with(Rays::kPinhole);
  const Sensors sensors = find_sensors({&view}, {1.7});
  ErrorModel model;
  model.add({SensorError::kPrincipalPoint, false}, sensors);
  const auto note_on = [&](double x, double y) {
    for (const auto& [k, pixels] : {std::pair{0u, x}, std::pair{1u, y}}) {
      ErrorParameter& parameter = model.parameters.at(k);
      parameter.value = pixels / sensors.models[0].natural(parameter.term, 1.0);
    }
    SensorCalibration result;
    result.errors.resize(1);
    describe_errors(sensors, {"front"}, model, model, result);
    return result.notes.at(0);
  };
  EXPECT_THAT(note_on(0.5, -12.0), AllOf(HasSubstr("(0.5, -12) pixels"), HasSubstr("cropped")));
  EXPECT_THAT(note_on(0.5, 0.1), AllOf(HasSubstr("(0.5, 0.1) pixels"), Not(HasSubstr("cropped"))));
}

TEST(CalibrationNotes, NameTheSensorsThatHaveTheError) {
  const RangeView a = view_with(Rays::kPinhole);
  RangeView b = a, c = a;
  b.camera = Camera::pinhole(kPixels, kPixels, {171.0, 165.0, 29.0, 30.5});
  c.camera = Camera::pinhole(kPixels, kPixels, {181.0, 165.0, 29.0, 30.5});
  const Sensors sensors = find_sensors({&a, &a, &b, &c}, {1.7, 1.7, 1.7, 1.7});
  ErrorModel model;
  model.add({SensorError::kPrincipalPoint, false}, sensors);
  ErrorModel deviation = model;
  for (std::size_t p = 0; p < model.parameters.size(); ++p) {
    const ErrorParameter& parameter = model.parameters[p];
    const double pixel = 1.0 / sensors.models[parameter.owner].natural(parameter.term, 1.0);
    deviation.parameters[p].value = 0.1 * std::abs(pixel);
    model.parameters[p].value =
        pixel * (parameter.owner == 0 ? 0.0 : 3.0 * static_cast<double>(parameter.owner));
  }
  SensorCalibration result;
  result.errors.resize(1);
  describe_errors(sensors, {"a0", "a1", "b", "c"}, model, deviation, result);
  EXPECT_THAT(result.notes.at(0), HasSubstr("sensor of b: the principal point"));
  EXPECT_THAT(result.notes[0], HasSubstr("(3, 3) pixels"));
  EXPECT_THAT(result.notes[0], HasSubstr("; sensor of c: the principal point"));
  EXPECT_THAT(result.notes[0], HasSubstr("(6, 6) pixels"));
  EXPECT_THAT(result.notes[0], Not(HasSubstr("sensor of a")));
}

// Three sensors, the first one of three views.
TEST(ErrorModel, TakesTheMedianRangeScaleForRight) {
  const RangeView a = view_with(Rays::kPinhole);
  RangeView b = a, c = a;
  b.camera = Camera::pinhole(kPixels, kPixels, {171.0, 165.0, 29.0, 30.5});
  c.camera = Camera::pinhole(kPixels, kPixels, {181.0, 165.0, 29.0, 30.5});
  const Sensors sensors = find_sensors({&a, &a, &a, &b, &c}, {1.7, 1.7, 1.7, 1.7, 1.7});
  const std::vector<double> ratios = {-0.001, -0.001, 0.006};
  ErrorModel model;
  model.add({SensorError::kRangeOffset, false}, sensors);
  model.add({SensorError::kRangeScale, false}, sensors);
  for (ErrorParameter& parameter : model.parameters) {
    const double unit = sensors.models[parameter.owner].natural(parameter.term, 1.0);
    parameter.value = parameter.choice == 0 ? 0.5 : ratios[parameter.owner] / unit;
  }
  EXPECT_DOUBLE_EQ(take_median_scale(model, sensors), -0.001);
  for (const ErrorParameter& parameter : model.parameters) {
    const double ratio = sensors.models[parameter.owner].natural(parameter.term, parameter.value);
    if (parameter.choice == 0)
      EXPECT_EQ(parameter.value, 0.5);
    else
      EXPECT_NEAR(ratio, ratios[parameter.owner] + 0.001, 1e-12);
  }
}

TEST(ErrorModel, KeepsRangeScalesThatAreNotThoseOfAll) {
  const RangeView view = view_with(Rays::kTable);
  const Sensors sensors = find_sensors({&view}, {1.7});
  ErrorModel model;
  EXPECT_EQ(take_median_scale(model, sensors), 0.0);
  model.add({SensorError::kRangeScale, false}, sensors);
  model.parameters[0].value = 0.3;
  EXPECT_EQ(take_median_scale(model, sensors), 0.0);
  EXPECT_EQ(model.parameters[0].value, 0.3);
}

TEST(FindSensors, TellsSensorsApartByTheirCameras) {
  const RangeView a = view_with(Rays::kPinhole), b = view_with(Rays::kTable);
  RangeView c = a;
  c.camera = Camera::pinhole(kPixels, kPixels, {171.0, 165.0, 29.0, 30.5});
  const Sensors sensors = find_sensors({&a, &b, &a, &c}, {1.7, 1.7, 1.7, 1.7});
  EXPECT_EQ(sensors.of_view, (std::vector<std::size_t>{0, 1, 0, 2}));
  EXPECT_EQ(sensors.models.size(), 3u);
}

}  // namespace
}  // namespace relief::registration
