#pragma once

#include "scan/discontinuities.h"
#include "scan/range_view.h"

namespace relief {

/// Standard deviation of the white noise of positions along the normal [unit], robustly from third
/// differences of the range along rows and columns; 0 where there are none.
double position_noise(const RangeView& view, const ConnectedGrid& grid, int threads);

/// Standard deviation of the slope of a plane [rad] that is fitted to a square window of half width
/// `radius` [pixels] of samples with that noise.
double slope_noise(double noise, double spacing, int radius);

}  // namespace relief
