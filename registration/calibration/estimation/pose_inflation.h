#pragma once

#include <vector>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/model/error_model.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// By what factor the deviation of each component of a pose is larger where the errors of a model
/// are estimated with the poses than where they are known; at least 1. World axes, about each
/// view's place in the sums' centre. 1 for held views.
std::vector<RigidTangent> pose_inflation(const std::vector<PairSums>& pairs, const Sensors& sensors,
                                         const ErrorModel& model, const std::vector<bool>& held);

}  // namespace relief::registration
