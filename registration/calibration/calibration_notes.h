#pragma once

#include <string>
#include <vector>

#include "registration/calibration/model/error_model.h"
#include "relief/registration/calibrate_views.h"

namespace relief::registration {

/// Sets the sizes of the errors that were found, and says in words what they are, of each sensor
/// where there are several: by its first view, of `view_names`. `deviation`: the model with the
/// standard deviations of its parameters as values.
void describe_errors(const Sensors& sensors, const std::vector<std::string>& view_names,
                     const ErrorModel& model, const ErrorModel& deviation,
                     SensorCalibration& result);

}  // namespace relief::registration
