#pragma once

#include <cstddef>

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"

namespace relief::reconstruction {

/// Adds `correction` to the ranges; NaN: none. Samples side by side that have one are a group. A
/// group stays as measured where correcting it does not halve the sum of squares of the steps
/// within it and to the samples beside it: the correction may come from another surface. So does a
/// group of four samples or fewer: beside a crease steps that small are halved by chance, and
/// refining removes flying samples itself. Returns how many samples changed.
std::size_t correct_ranges(const Grid<float>& correction, RangeView& view);

}  // namespace relief::reconstruction
