#pragma once

#include <vector>

#include "registration/align_views.h"
#include "scan/range_view.h"

namespace relief {

/// Gives `views`, those that were aligned and in the same order, the poses found. An aligned view
/// that had no pose has a guess from then on, so that merging takes it; a known pose stays known.
/// Views that were not aligned stay as they are.
void apply_alignment(const Alignment& alignment, std::vector<RangeView>& views);

}  // namespace relief
