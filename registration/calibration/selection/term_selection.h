#pragma once

#include <vector>

#include "registration/calibration/model/error_model.h"
#include "registration/calibration/selection/held_out.h"
#include "relief/registration/calibrate_views.h"

namespace relief::registration {

/// What held-out correspondences gain by an error: the part by which their sum of squares falls,
/// and its standard error over the folds.
struct HeldOutGain {
  double gain = 0.0, deviation = 0.0;
};

struct SelectedErrors {
  std::vector<HeldOutGain> gains;  ///< Of the errors that were added to the model, in their order.
  /// What an error that views do not share would gain, where it was not asked for; 0: nothing.
  double gain_per_view = 0.0;
};

/// Adds to `model`, one after the other, the errors by which held-out correspondences gain most, as
/// long as they gain by more than chance: those that views share, then, in the scope kPerView,
/// those that views have apart. Then narrows the prior of the model as far as the motion of the
/// views demands.
SelectedErrors select_errors(const HeldOutTest& test, const Sensors& sensors,
                             CalibrationScope scope, ErrorModel& model);

}  // namespace relief::registration
