#pragma once

#include <string>
#include <vector>

#include "apps/reports/report.h"
#include "relief/scan/range_view.h"

namespace relief {

/// What aligning once more on refined views changed, from the `align` sections of both times:
/// `rms` and `pose_std` (median over the free views of the standard deviation of a view's centre)
/// as `first` and `again`, `moved`, the mean distance that the samples of `views` went [unit],
/// `left_out`, how many views no longer fit the others, as those do whose calibration errs by more
/// than the noise that refining left, and `kept`: whether the poses are expected to be no worse
/// than before. Views are matched by name; those that were not aligned both times are left out.
Json alignment_gain(const Json& first, const Json& again, const std::vector<RangeView>& views);

/// The same as lines for people.
std::vector<std::string> gain_table(const Json& gain, const std::string& unit);

}  // namespace relief
