#pragma once

#include <span>

namespace relief {

/// The number that depths hold where nothing was measured, other than 0, as 65535 or 9999: the
/// largest value, which several and more than a hundredth of those above 0 share, and none is in
/// the three quarters below it. A surface that far behind all others would have more than one
/// depth. Infinity where there is no such number.
double invalid_depth_value(std::span<const float> depths);

}  // namespace relief
