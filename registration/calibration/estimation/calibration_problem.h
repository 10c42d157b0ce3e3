#pragma once

#include <vector>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/model/error_model.h"
#include "relief/registration/align_views.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The step that brings poses and errors to the least of (C2), as linearised.
struct CalibrationStep {
  std::vector<RigidTangent> tangents;  ///< About the centre of the sums; zero for held views.
  std::vector<double> errors;          ///< Of the parameters of the model.
  SolverSummary summary;

  bool usable() const { return summary.termination != SolverTermination::kFailed; }
};

/// Solves for all poses and errors together with Ceres: a block of six tangent components per view,
/// a block of parameters per sensor and per view, and as many residuals per directed pair as it has
/// unknowns, and one (R6).
CalibrationStep solve_calibration(const std::vector<PairSums>& pairs, const Sensors& sensors,
                                  const ErrorModel& model, const std::vector<bool>& held);

}  // namespace relief::registration
