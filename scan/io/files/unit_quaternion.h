#pragma once

namespace relief {

/// The largest deviation of a unit quaternion's length from 1 that is rounding: what three decimals
/// leave of four numbers, 0.0005 sqrt(4).
inline constexpr double kUnitQuaternion = 1e-3;

}  // namespace relief
