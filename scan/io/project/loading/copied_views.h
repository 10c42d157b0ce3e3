#pragma once

#include <string>
#include <vector>

#include "relief/scan/range_view.h"

namespace relief {

/// Leaves out views without poses whose samples are those of another one to the bit: copies, not
/// measured again, whose noise would seem to be shape. Of two without poses one with colours or
/// normals is kept. Returns notes on these and on copies with poses, for the user.
std::vector<std::string> leave_out_copies(std::vector<RangeView>& views);

/// The notes alone.
std::vector<std::string> notes_on_copies(const std::vector<RangeView>& views);

}  // namespace relief
