#pragma once

#include <cstddef>

#include "hybrid/model/range_steps.h"
#include "relief/scan/discontinuities.h"
#include "relief/scan/range_view.h"

namespace relief::hybrid {

/// The errors of one view's measurements, estimated from how its ranges and normals disagree.
struct NoiseEstimate {
  /// Standard deviation of a range along the ray [unit]: that of independent noise which is as
  /// harmful over long waves as the view's, whose neighbouring samples may err alike.
  double sigma_position = 0.0;
  double sigma_local = 0.0;    ///< Of a range against those next to it; at most sigma_position.
  double sigma_normal = 0.0;   ///< Of a normal's slope along one tangent, white part [rad].
  double bias = 0.0;           ///< RMS of the smooth slope error of the normals [rad].
  double bias_gradient = 0.0;  ///< RMS change of that error from pixel to pixel [rad].
  std::size_t samples = 0;     ///< Independent comparisons used; below 30 nothing is estimated.
  bool enough() const { return samples >= 30; }
  bool usable() const { return enough() && sigma_position > 0.0 && sigma_normal > 0.0; }
};

/// Robust estimates, free of tuning and of units. Three statistics are compared with their models:
/// the closure of the steps that the normals imply round small loops (normal noise alone, equation
/// (H7)), second differences of the discrepancy over walks of k edges (position noise, equation
/// (H8)), and its first differences over long walks (bias, equation (H9)).
NoiseEstimate estimate_noise(const RangeSteps& steps);

NoiseEstimate estimate_noise(const RangeView& view, const GridEdges& edges);

}  // namespace relief::hybrid
