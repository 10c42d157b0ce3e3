#pragma once

#include <string>
#include <vector>

#include "relief/scan/range_view.h"

namespace relief {

/// Leaves out views whose samples are those of another one to the bit: copies, not measured again,
/// whose noise would seem to be shape. Of two, one with colours or normals is kept. A copy with a
/// pose of its own stays. Returns notes on both, for the user.
std::vector<std::string> leave_out_copies(std::vector<RangeView>& views);

}  // namespace relief
