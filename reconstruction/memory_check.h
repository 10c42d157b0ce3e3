#pragma once

#include <cstddef>
#include <vector>

#include "relief/hybrid/refine_view.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::reconstruction {

/// Whether `views` can be aligned and refined within `limit` [bytes] of the
/// whole process; 0: no limit. Error: kUnsolvable, which tells how much is needed.
Result<void> check_memory_to_refine(const std::vector<RangeView>& views,
                                    const hybrid::RefineOptions& options, std::size_t limit);

/// Whether a mesh of `vertices` can be polished within `limit`, as above.
Result<void> check_memory_to_polish(std::size_t vertices, std::size_t limit);

}  // namespace relief::reconstruction
