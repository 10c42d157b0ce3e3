#pragma once

#include <cstddef>
#include <vector>

#include "registration/calibration/model/sensor_model.h"
#include "relief/registration/calibrate_views.h"

namespace relief::registration {

/// An error that is estimated, and by whom it is shared.
struct ErrorChoice {
  SensorError error = SensorError::kRangeOffset;
  bool per_view = false;  ///< Else one for all views of a sensor.

  bool operator==(const ErrorChoice&) const = default;
};

/// One number that is estimated: the coefficient of a term of a sensor, for one view or for all
/// views of the sensor.
struct ErrorParameter {
  std::size_t choice = 0;  ///< Index into the choices of its model.
  std::size_t owner = 0;   ///< The view, or the sensor where it is shared.
  std::size_t term = 0;    ///< Of the sensor.
  double value = 0.0;      ///< [sample spacings, root mean square]
};

/// The errors that are estimated, with their coefficients.
struct ErrorModel {
  std::vector<ErrorChoice> choices;
  std::vector<ErrorParameter> parameters;
  /// Standard deviation of a coefficient before any correspondence is known [sample spacings].
  double prior_deviation = 1.0;

  /// The precision that goes with it.
  double prior() const { return 1.0 / (prior_deviation * prior_deviation); }

  /// Adds an error with all its parameters, which are 0.
  void add(const ErrorChoice& choice, const Sensors& sensors);

  bool has(const ErrorChoice& choice) const;

  /// Whether a parameter takes part in the coefficients of a view.
  bool concerns(const ErrorParameter& parameter, std::size_t view, const Sensors& sensors) const;

  /// Of all terms of a view's sensor (C1).
  std::vector<double> coefficients(std::size_t view, const Sensors& sensors) const;
};

/// Takes the median over the views of the errors of range scale, a ratio, from all of them, and
/// returns it. Views whose rays start from one point fit each other as well when all ranges and
/// positions grow by one factor, so most views are taken for right. Returns 0, and changes nothing,
/// where no error of scale is estimated, or where rays of a sensor do not start from one point.
double take_median_scale(ErrorModel& model, const Sensors& sensors);

}  // namespace relief::registration
