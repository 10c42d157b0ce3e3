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

/// Patches of normals that err alike, by a highlight or a shadow, convince each other; only the
/// ranges contradict them. A sample belongs to such a patch if the mean slope of a window of
/// measured ranges against its normals differs from that of the windows round about by more than
/// six standard deviations under `noise` and more than the bias changes over that distance. The
/// error is that difference. `spacing` is a typical length of the constraints [unit].
CoherentErrors coherent_errors(const ViewProblem& problem, const NoiseEstimate& noise,
                               double spacing, int threads = 1);

}  // namespace relief::hybrid
