#include "hybrid/solver/view_solver.h"

#include "hybrid/model/view_system.h"
#include "hybrid/multigrid/view_multigrid.h"
#include "hybrid/solver/spd_solver.h"

namespace relief::hybrid {

namespace {

class DirectSolver : public ViewSolver {
 public:
  DirectSolver(const ViewProblem& problem, bool with_bias) : system_(problem, with_bias) {}

  bool set_weights(ViewWeights weights) override {
    system_.assemble(weights);
    return solver_.factorise(system_.lower());
  }
  LinearSolve minimise(Eigen::VectorXd& y, double tolerance, int max_iterations) override {
    y = system_.rhs();
    return solve(y, tolerance, max_iterations);
  }
  LinearSolve solve(Eigen::VectorXd& y, double, int) override {
    y = solver_.solve(y);
    return {y.allFinite(), 1};
  }

 private:
  ViewSystem system_;
  SpdSolver solver_;
};

}  // namespace

std::unique_ptr<ViewSolver> make_view_solver(const ViewProblem& problem, bool with_bias,
                                             Solver solver) {
  if (solver == Solver::kMultigrid && problem.slopes.stencil == Stencil::kCompactEdge)
    return std::make_unique<ViewMultigrid>(problem, with_bias);
  return std::make_unique<DirectSolver>(problem, with_bias);
}

}  // namespace relief::hybrid
