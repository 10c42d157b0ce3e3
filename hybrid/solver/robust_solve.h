#pragma once

#include <Eigen/Core>

#include "hybrid/model/view_problem.h"
#include "hybrid/noise/noise_model.h"
#include "relief/hybrid/refine_view.h"
#include "relief/scan/context.h"

namespace relief::hybrid {

struct RobustSolve {
  Eigen::VectorXd y;          ///< [x; b_u; b_v], or x without a bias.
  Eigen::VectorXf deviation;  ///< Standard deviations of x [unit]; empty when not found.
  RefineStatus status = RefineStatus::kRefined;
  int rounds = 0;      ///< Linear systems solved.
  int iterations = 0;  ///< Steps of the linear solver, all rounds together.
  bool interrupted = false;
};

/// Minimises equation (H5) by least squares whose slope constraints are reweighted, with Cauchy's
/// loss, until the samples settle or after `options.robust_rounds`.
RobustSolve solve_robustly(const ViewProblem& problem, const NoiseModel& noise,
                           const RefineOptions& options, const Context& context);

}  // namespace relief::hybrid
