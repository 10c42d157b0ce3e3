#include "hybrid/solver/spd_solver.h"

#include <Eigen/CholmodSupport>

namespace relief::hybrid {

struct SpdSolver::Factor {
  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>, Eigen::Lower> cholesky;
  bool analysed = false;
};

SpdSolver::SpdSolver() : factor_(std::make_unique<Factor>()) {
  factor_->cholesky.cholmod().print = 0;
}

SpdSolver::~SpdSolver() = default;

bool SpdSolver::factorise(const Eigen::SparseMatrix<double>& lower) {
  if (!factor_->analysed) factor_->cholesky.analyzePattern(lower);
  factor_->analysed = true;
  factor_->cholesky.factorize(lower);
  return factor_->cholesky.info() == Eigen::Success;
}

Eigen::VectorXd SpdSolver::solve(const Eigen::VectorXd& rhs) const {
  return factor_->cholesky.solve(rhs);
}

}  // namespace relief::hybrid
