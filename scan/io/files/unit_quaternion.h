#pragma once

namespace relief {

/// The largest deviation of a unit quaternion's length from 1 that is rounding: what three decimals
/// leave of four numbers, 0.0005 sqrt(4).
inline constexpr double kUnitQuaternion = 1e-3;
/// The same of two decimals, 0.005 sqrt(4), as texts that people write have them.
inline constexpr double kRoundedQuaternion = 1e-2;

}  // namespace relief
