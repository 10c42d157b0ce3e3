#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "hybrid/model/view_problem.h"
#include "hybrid/noise/noise.h"

namespace relief::hybrid {

struct CoherentErrors {
  Eigen::VectorXd
      slopes;  ///< [b_u; b_v] of the movable samples [rad]; zero where nothing is wrong.
  std::size_t samples = 0;  ///< With an error along either axis.
};

/// Finds patches of outlier normals: a highlight or a shadow turns all normals of a patch alike, so
/// that they agree with each other and only the ranges contradict them. A sample belongs to such a
/// patch if the slope of the ranges against the normals, averaged over a window, differs from that
/// of the surrounding windows by more than six standard deviations under `noise`, and by more than
/// the bias changes over that distance. That difference is the error of the normals. `spacing` is a
/// typical length of the constraints [unit].
CoherentErrors coherent_errors(const ViewProblem& problem, const NoiseEstimate& noise,
                               double spacing);

}  // namespace relief::hybrid
