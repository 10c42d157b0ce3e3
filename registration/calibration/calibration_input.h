#pragma once

#include <vector>

#include "registration/posegraph/view_graph.h"
#include "relief/registration/align_views.h"
#include "relief/scan/range_view.h"

namespace relief::registration {

/// The pairs that calibration uses: those of the largest overlaps of each view that are no misfits.
std::vector<ViewPair> fitting_pairs(const Alignment& aligned);

/// The gauge: known poses, views without pairs, and the first view of each group without a known
/// pose.
std::vector<bool> held_views(const std::vector<RangeView>& views,
                             const std::vector<ViewPair>& pairs);

/// Whether the shape of the pairs holds every view that has pairs.
bool shape_holds_all(const Alignment& aligned);

/// All that a surface without normal maps is made of.
RangeView ranges_of(const RangeView& view);

}  // namespace relief::registration
