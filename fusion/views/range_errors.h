#pragma once

#include <cmath>

namespace relief::fusion {

/// Standard deviations of single views that a truncation holds: surfaces farther apart than it stay
/// two sheets.
inline constexpr double kTruncatedDeviations = 4.0;

/// How the errors of views grow with the distance from their sensors: as a power of it. Sensors
/// that triangulate have the exponent 2, one of time of flight has one between 0 and 2.
struct RangeErrors {
  double stddev = 0.0;         ///< At the typical range, along the normal [unit]; 0: unknown.
  double typical_range = 0.0;  ///< Distance from the sensor [unit].
  double exponent = 0.0;       ///< 0: the same at all ranges.

  /// The standard deviation at a range, in units of that at the typical one.
  double relative_stddev(double range) const {
    return exponent > 0.0 ? std::pow(range / typical_range, exponent) : 1.0;
  }
};

}  // namespace relief::fusion
