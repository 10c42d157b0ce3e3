#pragma once

#include <vector>

#include "registration/calibration/model/error_model.h"
#include "registration/calibration/selection/held_out.h"
#include "registration/calibration/selection/left_out_views.h"
#include "relief/registration/calibrate_views.h"

namespace relief::registration {

/// What correspondences of other places gain by an error, and those of views that took no part.
struct ErrorGain {
  HeldOutGain places, views;
};

struct SelectedErrors {
  std::vector<ErrorGain> gains;  ///< Of the errors that were added to the model, in their order.
  /// What places gain by an error per view that other views do not confirm; 0: nothing.
  double unconfirmed_gain = 0.0;
};

/// Adds to `model`, one after the other, the errors by which held-out correspondences gain most, as
/// long as they gain by more than chance, and views that are left out gain as well: those that
/// views share, then those that views have apart. In the scope kPerView the latter need no
/// confirmation by other views. Then narrows the prior of the model as far as the motion of the
/// views demands.
SelectedErrors select_errors(const HeldOutTest& places, const LeftOutViewsTest& views,
                             const Sensors& sensors, CalibrationScope scope, ErrorModel& model);

}  // namespace relief::registration
