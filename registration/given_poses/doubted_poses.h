#pragma once

#include <vector>

#include "relief/registration/align_views.h"
#include "relief/scan/range_view.h"

namespace relief::registration {

/// Takes `verified` from views, but for those of known poses, where refining had not settled: its
/// last step still moved samples by more than they are apart, and by more than poses err by. Where
/// errors of ranges fill the distance within which partners are looked for, steps lead anywhere,
/// and views fit as well wherever they lead.
void doubt_unsettled_poses(const std::vector<RangeView>& views, Alignment& alignment);

/// The median standard deviation of the centres of views that can move [unit]; 0 where none can.
double median_deviation(const Alignment& alignment);

}  // namespace relief::registration
