#pragma once

#include <cmath>

namespace relief::fusion {

/// How the errors of views grow with the distance from their sensors: as a power of it. Sensors
/// that triangulate have the exponent 2, one of time of flight has one between 0 and 2.
struct RangeErrors {
  double stddev = 0.0;    ///< At the typical distance, along the normal [unit]; 0: unknown.
  double distance = 0.0;  ///< The typical one [unit].
  double exponent = 0.0;  ///< 0: the same at all distances.

  /// The standard deviation at a distance, in units of that at the typical one.
  double relative_stddev(double at) const {
    return exponent > 0.0 ? std::pow(at / distance, exponent) : 1.0;
  }
};

}  // namespace relief::fusion
