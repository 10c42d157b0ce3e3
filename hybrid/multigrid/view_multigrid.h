#pragma once

#include <memory>

#include <Eigen/Core>

#include "hybrid/model/view_problem.h"
#include "hybrid/solver/view_solver.h"

namespace relief::hybrid {

/// Conjugate gradients with multigrid for the normal equations of a view with the compact stencil:
/// A y = b as of ViewSystem, never assembled. A set-up serves as many right sides as needed.
class ViewMultigrid : public ViewSolver {
 public:
  /// `problem` must have the compact stencil and outlive the object.
  ViewMultigrid(const ViewProblem& problem, bool with_bias);
  ~ViewMultigrid() override;

  bool set_weights(ViewWeights weights) override;
  LinearSolve minimise(Eigen::VectorXd& y, double tolerance, int max_iterations) override;
  LinearSolve solve(Eigen::VectorXd& y, double tolerance, int max_iterations) override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace relief::hybrid
