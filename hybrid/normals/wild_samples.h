#pragma once

#include <cstdint>

#include "hybrid/model/range_steps.h"
#include "hybrid/noise/noise.h"
#include "relief/scan/grid.h"

namespace relief::hybrid {

/// `steps` are those between all neighbouring samples. 1 for samples whose range alone is wrong:
/// all their steps to neighbours, or all but one of four, lead the same way and are each more than
/// five standard deviations off what the normals explain. `variance`, if not empty, is that of the
/// range of each pixel over that of `noise`.
Grid<std::uint8_t> range_outliers(const RangeSteps& steps, const NoiseEstimate& noise,
                                  const Grid<float>& variance = {});

}  // namespace relief::hybrid
