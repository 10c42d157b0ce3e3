#pragma once

#include <cmath>

namespace relief::fusion {

/// Standard deviations of single views that a truncation holds: surfaces farther apart than it stay
/// two sheets.
inline constexpr double kTruncatedDeviations = 4.0;

/// The errors of views. Where samples know no deviations, these grow with a power of the distance
/// from the sensor. Sensors that triangulate have the exponent 2, one of time of flight has one
/// between 0 and 2. Where samples know theirs, views err by more than that: noise averages out in a
/// view that is refined, its calibration and its pose do not.
struct RangeErrors {
  double stddev = 0.0;         ///< At the typical range, along the normal [unit]; 0: unknown.
  double typical_range = 0.0;  ///< Distance from the sensor [unit].
  double exponent = 0.0;       ///< 0: the same at all ranges.
  /// Standard deviation of an observation whose information is 1, as its samples know it [unit]; 0:
  /// they know none.
  double nominal_deviation = 0.0;
  double excess_variance = 0.0;  ///< Variance beyond that which samples know [unit^2].

  /// The standard deviation at a range, in units of that at the typical one.
  double relative_stddev(double range) const {
    return exponent > 0.0 ? std::pow(range / typical_range, exponent) : 1.0;
  }
  /// The variance of an observation, in units of that by which its samples weigh it: equation
  /// (F2a). `information`: by its samples.
  double relative_variance(double information, double relative_stddev) const {
    if (!(nominal_deviation > 0.0)) return relative_stddev * relative_stddev;
    return 1.0 + information * excess_variance / (nominal_deviation * nominal_deviation);
  }
  /// The standard deviation of an observation [unit], by its information.
  double stddev_at(double information, double relative_stddev) const {
    return nominal_deviation > 0.0 ? nominal_deviation / std::sqrt(information)
                                   : stddev * relative_stddev;
  }
};

}  // namespace relief::fusion
