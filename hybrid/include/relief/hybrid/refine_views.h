#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "relief/hybrid/refine_view.h"

namespace relief::hybrid {

/// Memory that refine_view() takes at most, beyond its input and its result [bytes].
std::size_t memory_to_refine(const RangeView& view, Solver solver);

/// Memory of the refined views [bytes].
std::size_t memory_of_refined(const std::vector<RangeView>& views);

/// How many of `views` are refined at once: as many as there are threads, as long as the memory
/// that refining the largest ones takes beyond that of the views themselves stays within `memory`
/// [bytes]; 0: half of usable_memory(). At least one.
int views_at_once(const std::vector<RangeView>& views, const RefineOptions& options,
                  std::size_t memory = 0);

/// Refines one view, as refine_view() does.
using RefineOne = std::function<Result<RefinedView>(
    const RangeView& view, const RefineOptions& options, const Context& context)>;

/// Refines all views, several at a time. The memory of the context is that of the whole process: as
/// many views are refined at once as it leaves room for, at least one. With fewer views than
/// threads each view gets several threads. The results are in the order of the views and do not
/// depend on the number of threads, nor on the memory. A view that cannot be refined stays as
/// measured; its status says why. `refine` is called for each view, from several threads at once.
/// Errors: kBadInput for an option out of range, kInterrupted.
Result<std::vector<RefinedView>> refine_views(const std::vector<RangeView>& views,
                                              const RefineOptions& options = {},
                                              const Context& context = {},
                                              const RefineOne& refine = refine_view);

}  // namespace relief::hybrid
