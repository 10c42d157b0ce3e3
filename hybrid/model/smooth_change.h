#pragma once

#include <Eigen/Core>

#include "hybrid/model/view_problem.h"

namespace relief::hybrid {

/// How much refining changed the ranges over blocks of 8 x 8 samples, and within them [unit]. The
/// tenth of the blocks that changed most is left out: wrong normals over small patches are no sign
/// of wrong normals everywhere.
struct SmoothChange {
  /// RMS of the means over blocks, less what independent changes of the samples leave in a mean,
  /// and less half of the rounding of the ranges.
  double between_blocks = 0.0;
  /// RMS about the plane through each block: about the noise of the samples.
  double within_blocks = 0.0;

  /// What was smoothed away is less than what was moved as a whole: the normals bent the surface.
  bool bent() const { return between_blocks > within_blocks; }
};

/// Of the changes `x` of the movable samples, in ranges that are rounded to `step` [unit] or not:
/// 0.
SmoothChange smooth_change(const ViewProblem& problem, const Eigen::VectorXd& x, double step);

}  // namespace relief::hybrid
