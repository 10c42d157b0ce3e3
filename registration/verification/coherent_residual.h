#pragma once

#include <vector>

#include <Eigen/Core>

namespace relief::registration {

/// Distances between points that may agree with each other [unit].
struct DistanceBand {
  double nearest = 0.0;   ///< Nearer ones share the noise of the sensor.
  double farthest = 0.0;  ///< Farther ones share nothing. > nearest.
};

/// The root mean square of what residuals at neighbouring points have in common (R10): the root of
/// the mean product of the residuals of all pairs of points whose distance lies in `band`. Noise
/// that is independent beyond the nearest distance averages out; a systematic misfit stays. 0 when
/// the products are negative on average or there are none.
double coherent_rms(const Eigen::Matrix3Xd& points, const std::vector<double>& residuals,
                    const DistanceBand& band);

}  // namespace relief::registration
