#pragma once

#include <memory>

#include <Eigen/Core>

#include "hybrid/model/view_problem.h"
#include "relief/hybrid/refine_view.h"

namespace relief::hybrid {

struct LinearSolve {
  bool converged = false;
  int iterations = 0;  ///< Conjugate gradient steps; 1 for a factorisation.
};

/// Solves A y = b, the normal equations of (H5): y = [x; b_u; b_v] of the movable samples, or y = x
/// without a bias. Once weights are set, any number of right sides can be solved for.
class ViewSolver {
 public:
  virtual ~ViewSolver() = default;

  /// Puts in weights. False: the matrix is not positive definite.
  virtual bool set_weights(ViewWeights weights) = 0;

  /// Minimises the objective. Iteration starts from `y`, of the size of the unknowns; the solution
  /// is left there. It ends when the preconditioned residual, which estimates the error, is below
  /// `tolerance` times that of y = 0 in energy and shows an error of x below `tolerance` times x.
  virtual LinearSolve minimise(Eigen::VectorXd& y, double tolerance, int max_iterations) = 0;

  /// The same for A y = b with any right side b: `y` holds b and is left with the solution.
  virtual LinearSolve solve(Eigen::VectorXd& y, double tolerance, int max_iterations) = 0;
};

/// `problem` must outlive the solver. No result depends on the number of threads.
std::unique_ptr<ViewSolver> make_view_solver(const ViewProblem& problem, bool with_bias,
                                             Solver solver);

}  // namespace relief::hybrid
