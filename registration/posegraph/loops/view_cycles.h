#pragma once

#include <cstddef>
#include <vector>

#include "registration/posegraph/view_graph.h"

namespace relief::registration {

/// Cycles of views that test all pairs: for each pair outside a spanning forest of the largest
/// overlaps a smallest cycle with that pair, each cycle once. Of several as small, the one whose
/// least overlap is largest. A cycle starts at its smallest view and goes on to the smaller one of
/// that view's neighbours; pairs join each view to the next, and the last to the first.
std::vector<std::vector<std::size_t>> smallest_cycles(std::size_t views,
                                                      const std::vector<ViewPair>& pairs);

}  // namespace relief::registration
