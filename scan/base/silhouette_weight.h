#pragma once

#include <algorithm>

namespace relief {

/// The weight of a sample `border` [pixels] from the boundary of its view (see boundary_distance):
/// it grows over `ramp` [pixels] up to 1 and is never zero. Samples beside a silhouette are the
/// least accurate: the spot of the sensor lies on both sides (Turk and Levoy 1994).
inline double silhouette_weight(double border, double ramp) {
  constexpr double kLeast = 0.1;  // [pixels]; keeps the weight positive.
  return std::min(1.0, (border + kLeast) / (ramp + kLeast));
}

}  // namespace relief
