#include "registration/calibration/calibration_notes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace relief::registration {

namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

// The root mean square over its owners of what the terms of an error move samples by [unit]: the
// fields are scaled to one spacing, and nearly orthogonal.
double size_of(const Sensors& sensors, const ErrorModel& model, std::size_t choice) {
  double sum = 0.0, owners = 0.0;
  const std::size_t count =
      model.choices[choice].per_view ? sensors.of_view.size() : sensors.models.size();
  for (std::size_t owner = 0; owner < count; ++owner) {
    const std::size_t sensor = model.choices[choice].per_view ? sensors.of_view[owner] : owner;
    double squares = 0.0;
    for (const ErrorParameter& parameter : model.parameters)
      if (parameter.choice == choice && parameter.owner == owner)
        squares += parameter.value * parameter.value;
    sum += squares * std::pow(sensors.models[sensor].spacing(), 2);
    owners += squares > 0.0 ? 1.0 : 0.0;
  }
  return owners > 0.0 ? std::sqrt(sum / owners) : 0.0;
}

// The parameters of an error of a sensor in their natural units.
std::vector<double> natural_values(const Sensors& sensors, const ErrorModel& model,
                                   std::size_t choice, std::size_t sensor) {
  std::vector<double> values;
  for (const ErrorParameter& parameter : model.parameters)
    if (parameter.choice == choice && parameter.owner == sensor)
      values.push_back(sensors.models[sensor].natural(parameter.term, parameter.value));
  return values;
}

std::string wrong_principal_point(double x, double y) {
  const std::string text = "the principal point (cx, cy) is off, and right when moved by (" +
                           number(x) + ", " + number(y) + ") pixels";
  const bool whole_pixels = std::hypot(x, y) >= 1.0;
  return whole_pixels
             ? text + ", as where images were cropped and the camera is that of the whole ones"
             : text;
}

std::string what_is_wrong(SensorError error, const std::vector<double>& values) {
  const double value = values.empty() ? 0.0 : values.front();
  const auto percent = [&](double part) { return number(std::abs(100.0 * part)) + " %"; };
  switch (error) {
    case SensorError::kRangeOffset:
      return "ranges are too " + std::string(value < 0.0 ? "long" : "short") + " by a length";
    case SensorError::kRangeScale:
      return "ranges are too " + std::string(value < 0.0 ? "long" : "short") + " by " +
             percent(value);
    case SensorError::kRangeNonlinearity:
      return "ranges are not linear";
    case SensorError::kQuadraticWarp:
      return "ranges tilt and bend over the image";
    case SensorError::kCubicWarp:
    case SensorError::kQuarticWarp:
      return "ranges bend over the image";
    case SensorError::kFocalLength:
      return "the focal length is too " + std::string(value < 0.0 ? "long" : "short") + " by " +
             percent(value);
    case SensorError::kAspectRatio:
      return "fx / fy is too " + std::string(value < 0.0 ? "large" : "small") + " by " +
             percent(2.0 * value);
    case SensorError::kPrincipalPoint:
      return values.size() < 2 ? "the principal point is off"
                               : wrong_principal_point(values[0], values[1]);
    case SensorError::kRadialDistortion:
      return "the lens distorts radially";
    case SensorError::kTangentialDistortion:
      return "the lens distorts tangentially";
    case SensorError::kInterlacing:
      return "every other row is shifted by " + number(std::abs(value)) + " columns";
    case SensorError::kRayLengths:
      return "distances along the rays are read as depths";
  }
  return "unknown error";
}

// Numbers of one view say nothing of the others.
std::string what_differs(SensorError error) {
  switch (error) {
    case SensorError::kRangeOffset:
    case SensorError::kRangeScale:
    case SensorError::kFocalLength:
    case SensorError::kAspectRatio:
    case SensorError::kPrincipalPoint:
    case SensorError::kInterlacing:
      return std::string(to_string(error)) + ", in every view another";
    default:
      return what_is_wrong(error, {}) + ", in every view differently";
  }
}

// Whether a sensor has an error beyond the deviation of its parameters.
bool has_error(const ErrorModel& model, const ErrorModel& deviation, std::size_t choice,
               std::size_t sensor) {
  constexpr double kDeviations = 2.0;  // 5 % of Gaussian values lie beyond.
  for (std::size_t p = 0; p < model.parameters.size(); ++p) {
    const ErrorParameter& parameter = model.parameters[p];
    if (parameter.choice == choice && parameter.owner == sensor &&
        std::abs(parameter.value) > kDeviations * deviation.parameters[p].value)
      return true;
  }
  return false;
}

// Of several sensors those that have the error, each named by its first view.
std::string what_each_has_wrong(const Sensors& sensors, const std::vector<std::string>& view_names,
                                const ErrorModel& model, const ErrorModel& deviation,
                                std::size_t choice) {
  const SensorError error = model.choices[choice].error;
  if (sensors.models.size() == 1)
    return what_is_wrong(error, natural_values(sensors, model, choice, 0));
  std::string text;
  for (std::size_t sensor = 0; sensor < sensors.models.size(); ++sensor) {
    if (!has_error(model, deviation, choice, sensor)) continue;
    const auto first = std::ranges::find(sensors.of_view, sensor) - sensors.of_view.begin();
    text += (text.empty() ? "sensor of " : "; sensor of ") +
            view_names[static_cast<std::size_t>(first)] + ": " +
            what_is_wrong(error, natural_values(sensors, model, choice, sensor));
  }
  return text.empty() ? std::string(to_string(error)) : text;
}

}  // namespace

void describe_errors(const Sensors& sensors, const std::vector<std::string>& view_names,
                     const ErrorModel& model, const ErrorModel& deviation,
                     SensorCalibration& result) {
  for (std::size_t c = 0; c < model.choices.size(); ++c) {
    CalibratedError& error = result.errors[c];
    error.size = size_of(sensors, model, c);
    error.size_std = size_of(sensors, deviation, c);
    result.notes.push_back(
        (error.per_view ? what_differs(error.error)
                        : what_each_has_wrong(sensors, view_names, model, deviation, c)) +
        ": moves samples by " + number(error.size) + " (deviation " + number(error.size_std) + ")");
  }
}

std::string_view to_string(SensorError error) {
  switch (error) {
    case SensorError::kRangeOffset:
      return "range offset";
    case SensorError::kRangeScale:
      return "range scale";
    case SensorError::kRangeNonlinearity:
      return "range non-linearity";
    case SensorError::kQuadraticWarp:
      return "quadratic warp";
    case SensorError::kCubicWarp:
      return "cubic warp";
    case SensorError::kQuarticWarp:
      return "quartic warp";
    case SensorError::kFocalLength:
      return "focal length";
    case SensorError::kAspectRatio:
      return "aspect ratio";
    case SensorError::kPrincipalPoint:
      return "principal point";
    case SensorError::kRadialDistortion:
      return "radial distortion";
    case SensorError::kTangentialDistortion:
      return "tangential distortion";
    case SensorError::kInterlacing:
      return "interlacing";
    case SensorError::kRayLengths:
      return "distances along the rays that are read as depths";
  }
  return "unknown";
}

}  // namespace relief::registration
