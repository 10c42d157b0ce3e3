#pragma once

#include "scan/io/images/image_io.h"

namespace relief {

/// The number that a depth map holds where nothing was measured, other than 0, as 65535 or 9999:
/// the largest value, which more than a hundredth of the pixels with values share, and none is in
/// the three quarters below it. A surface that far behind all others would have more than one
/// depth. Infinity where there is no such number.
double invalid_depth_value(const Image& depth);

}  // namespace relief
