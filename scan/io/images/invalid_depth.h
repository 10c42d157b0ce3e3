#pragma once

#include <span>

namespace relief {

/// The number that depths hold where nothing was measured, other than 0, as 65535 or 9999: the
/// largest value, which several and more than a hundredth of those above 0 share, and none is in
/// the three quarters below it, or which is the largest of 16 bits. A surface that far behind all
/// others would have more than one depth. Infinity where there is no such number.
double invalid_depth_value(std::span<const float> depths);

/// Whether a depth is 65535, the largest number of 16 bits, or a tenth, a hundredth, ... of it: in
/// other units.
bool is_largest_of_16_bits(double depth);

}  // namespace relief
