#pragma once

#include <vector>

#include "hybrid/refine_view.h"

namespace relief {

/// Refines all views, several at a time. The results are in the order of the views and do not
/// depend on the number of threads. A view that cannot be refined stays as measured; its status
/// says why. Errors: kBadInput for an option out of range, kInterrupted when `progress` asks to
/// stop.
Result<std::vector<RefinedView>> refine_views(const std::vector<RangeView>& views,
                                              const RefineOptions& options = {},
                                              const Progress& progress = {});

}  // namespace relief
