#pragma once

#include "relief/scan/range_view.h"

namespace relief {

/// The median deviation of the samples whose deviation is known [unit]; 0 for none.
float median_deviation(const RangeView& view);

}  // namespace relief
