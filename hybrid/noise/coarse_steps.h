#pragma once

#include "hybrid/model/range_steps.h"

namespace relief::hybrid {

/// The steps from block to block of `factor` x `factor` samples, between the mean ranges of the
/// blocks. Blocks at which any step is missing have none. Errors that neighbouring samples share
/// average out less than independent ones: the noise of these steps, times `factor`, is what an
/// independent noise would have to be to do as much harm over long waves.
RangeSteps coarse_steps(const RangeSteps& steps, int factor);

}  // namespace relief::hybrid
