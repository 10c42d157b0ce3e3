#pragma once

#include <string>

#include "relief/scan/range_view.h"

namespace relief {

/// The bytes of an organized binary PCD with the points of a view in its own frame, as PCL's point
/// types hold them: in 32-bit floats, NaN where there is no sample, with normals, confidence and
/// packed colours where the view has them. VIEWPOINT is the view's pose.
std::string encode_pcd_grid(const RangeView& view);

}  // namespace relief
