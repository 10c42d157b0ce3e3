#pragma once

#include "hybrid/model/range_steps.h"
#include "hybrid/noise/noise.h"
#include "relief/scan/discontinuities.h"

namespace relief::hybrid {

/// `edges` without those that cross a step which the normals do not explain: three samples on one
/// side lie together above or below three on the other by more than five standard deviations of
/// that difference under `noise`. Single wild samples cut nothing. `variance`, if not empty, is
/// that of the range of each pixel over that of `noise`.
GridEdges cut_unexplained_steps(const GridEdges& edges, const RangeSteps& steps,
                                const NoiseEstimate& noise, const Grid<float>& variance = {});

}  // namespace relief::hybrid
