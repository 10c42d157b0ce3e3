#pragma once

#include <vector>

#include "fusion/views/view_sampler.h"

namespace relief::fusion {

/// Robust standard deviation of the errors that views do not share [unit]: noise, calibration and
/// poses together. From the distances of samples of each view, along the normal, to the surfaces
/// that the other views see there: two views of equal errors differ by sqrt(2) of it. 0: too few
/// samples are seen twice. The order of the views does not matter.
///
/// Differences beyond eight sample spacings are those of other surfaces; views that differ by more
/// throughout have no common surface.
double inter_view_stddev(const std::vector<ViewSampler>& views);

}  // namespace relief::fusion
