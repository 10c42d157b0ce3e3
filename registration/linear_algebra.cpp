#include "registration/linear_algebra.h"

#include <Eigen/Cholesky>

namespace relief::registration {

Eigen::SelfAdjointEigenSolver<Matrix6d> eigen_decomposition(const Matrix6d& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(symmetric);
}

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen_decomposition(
    const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric);
}

Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return Eigen::LDLT<Eigen::MatrixXd>(a).solve(b);
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return Eigen::LDLT<Eigen::MatrixXd>(a).solve(b);
}

std::optional<Eigen::VectorXd> solve_positive_definite(const Eigen::MatrixXd& a,
                                                       const Eigen::VectorXd& b) {
  const Eigen::LLT<Eigen::MatrixXd> factor(a);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return factor.solve(b);
}

}  // namespace relief::registration
