#pragma once

#include <cstddef>
#include <vector>

#include "relief/hybrid/refine_view.h"

namespace relief::hybrid {

/// Memory that refine_view() takes at most, beyond its input and its result [bytes].
std::size_t memory_to_refine(const RangeView& view, Solver solver);

/// How many of `views` are refined at once: as many as there are threads, as long as the memory
/// that refining the largest ones takes beyond that of the views themselves stays within `memory`
/// [bytes]; 0: half of usable_memory(). At least one.
int views_at_once(const std::vector<RangeView>& views, const RefineOptions& options,
                  std::size_t memory = 0);

}  // namespace relief::hybrid
