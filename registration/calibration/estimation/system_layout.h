#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "registration/calibration/model/error_model.h"
#include "registration/calibration/model/sensor_model.h"

namespace relief::registration {

/// Where the unknowns of a calibration stand: those of the poses of the views that move in one
/// vector, and in another the coefficients of all terms, of each view or of each sensor.
struct SystemLayout {
  std::vector<Eigen::Index> pose;   ///< Of each view, the first of six; -1: it is held.
  std::vector<Eigen::Index> terms;  ///< Of each view, its first coefficient.
  Eigen::Index poses = 0, coefficients = 0;
  bool per_view = false;

  SystemLayout(const Sensors& sensors, const std::vector<bool>& held, bool per_view);

  /// The coefficients that a parameter of a model adds to.
  std::vector<Eigen::Index> coefficients_of(const ErrorModel& model,
                                            const ErrorParameter& parameter,
                                            const Sensors& sensors) const;
  /// The coefficients that each parameter of a model adds to.
  std::vector<std::vector<Eigen::Index>> coefficients_of(const ErrorModel& model,
                                                         const Sensors& sensors) const;
};

}  // namespace relief::registration
