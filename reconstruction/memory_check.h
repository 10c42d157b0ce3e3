#pragma once

#include <cstddef>
#include <vector>

#include "relief/hybrid/refine_view.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::reconstruction {

/// Whether `views` can be aligned and refined within the limit of the enclosing run_in(), if it has
/// one. Error: kUnsolvable, which tells how much is needed.
Result<void> check_memory_to_refine(const std::vector<RangeView>& views,
                                    const hybrid::RefineOptions& options);

/// Whether a mesh of `vertices` can be polished within that limit, as above.
Result<void> check_memory_to_polish(std::size_t vertices);

}  // namespace relief::reconstruction
