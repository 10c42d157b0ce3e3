#pragma once

#include <numbers>

namespace relief::testing {

inline constexpr double kDegree = std::numbers::pi / 180.0;  ///< [rad]

}  // namespace relief::testing
