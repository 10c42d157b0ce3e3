#pragma once

#include <vector>

#include "registration/surface/view_surface.h"
#include "relief/registration/align_options.h"
#include "relief/registration/align_views.h"
#include "relief/scan/range_view.h"

namespace relief::registration {

/// Adds to the covariances of the poses what errors of the sensors may have done to these, where
/// held-out correspondences fit better with such an error than without (R19), and a note that says
/// so. `surfaces`: of the views. Nothing is added where fewer than three views overlap, where shape
/// alone does not hold all views, and where the sensors have more than 2500 terms together.
void include_sensor_errors(const std::vector<RangeView>& views,
                           const std::vector<ViewSurface>& surfaces,
                           const JointRefinementOptions& refinement, Alignment& alignment);

}  // namespace relief::registration
