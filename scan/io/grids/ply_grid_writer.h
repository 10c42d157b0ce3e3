#pragma once

#include <string>

#include "relief/scan/range_view.h"

namespace relief {

/// The bytes of a binary range-grid PLY with the points of a view in its own frame, in doubles,
/// with normals and confidence where the view has them.
std::string encode_ply_grid(const RangeView& view);

}  // namespace relief
