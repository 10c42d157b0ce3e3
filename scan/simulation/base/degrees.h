#pragma once

#include <numbers>

namespace relief::simulation {

inline double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

}  // namespace relief::simulation
