#pragma once

#include "relief/registration/align_views.h"

namespace ceres {
class Problem;
}

namespace relief::registration {

struct SparseSolverOptions {
  SolverStage stage = SolverStage::kJoint;
  int max_iterations = 2;
  /// Whether the cost is quadratic: the first step is then the whole way, without damping.
  bool quadratic = false;
};

/// Levenberg-Marquardt with sparse Cholesky factors, silent and the same at any number of threads.
[[nodiscard]] SolverSummary solve_sparse(ceres::Problem& problem,
                                         const SparseSolverOptions& options);

}  // namespace relief::registration
