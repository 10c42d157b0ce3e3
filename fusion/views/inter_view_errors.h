#pragma once

#include <vector>

#include "fusion/views/range_errors.h"
#include "fusion/views/view_sampler.h"

namespace relief::fusion {

/// The errors that views do not share: noise, calibration and poses together. From the distances of
/// samples of each view, along the normal, to the surfaces that the other views see there. Their
/// standard deviation is robust: two views of equal errors differ by sqrt(2) of it. It is 0 when
/// too few samples are seen twice. The order of the views does not matter.
///
/// The exponent is two standard errors below the one that fits best, so errors that hardly depend
/// on the distance have 0. It is 0, too, for fewer than four views that overlap others, and for
/// sensors without a centre.
///
/// Differences beyond eight sample spacings are those of other surfaces; views that differ by more
/// throughout have no common surface.
RangeErrors inter_view_errors(const std::vector<ViewSampler>& views);

}  // namespace relief::fusion
