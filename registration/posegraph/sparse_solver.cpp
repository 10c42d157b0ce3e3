#include "registration/posegraph/sparse_solver.h"

#include <algorithm>

#include <ceres/problem.h>
#include <ceres/solver.h>

namespace relief::registration {

namespace {

ceres::Solver::Options solver_options(const SparseSolverOptions& given) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = given.max_iterations;
  options.num_threads = 1;  // Parallel sums would depend on the number of threads.
  options.logging_type = ceres::SILENT;
  if (given.quadratic) {
    options.initial_trust_region_radius = options.max_trust_region_radius = 1e32;
    options.function_tolerance = 0.0;  // Steps far below a standard deviation count.
  }
  return options;
}

SolverTermination termination_of(const ceres::Solver::Summary& summary) {
  if (!summary.IsSolutionUsable()) return SolverTermination::kFailed;
  return summary.termination_type == ceres::NO_CONVERGENCE ? SolverTermination::kIterationLimit
                                                           : SolverTermination::kConverged;
}

}  // namespace

SolverSummary solve_sparse(ceres::Problem& problem, const SparseSolverOptions& options) {
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(options), &problem, &summary);
  return {options.stage,
          termination_of(summary),
          std::max(0, static_cast<int>(summary.iterations.size()) - 1),  // The first is the start.
          summary.initial_cost,
          summary.final_cost,
          summary.message,
          summary.total_time_in_seconds};
}

std::string_view to_string(SolverTermination termination) {
  switch (termination) {
    case SolverTermination::kConverged:
      return "converged";
    case SolverTermination::kIterationLimit:
      return "iteration limit";
    case SolverTermination::kFailed:
      return "failed";
  }
  return "unknown";
}

std::string_view to_string(SolverStage stage) {
  switch (stage) {
    case SolverStage::kJoint:
      return "joint";
    case SolverStage::kPoseGraph:
      return "pose graph";
    case SolverStage::kCalibration:
      return "calibration";
  }
  return "unknown";
}

}  // namespace relief::registration
