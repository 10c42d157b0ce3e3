#include "scan/base/linear_algebra.h"

#include <Eigen/Cholesky>

namespace relief {

Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen_decomposition(
    const Eigen::Matrix3d& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(symmetric);
}

Eigen::SelfAdjointEigenSolver<Matrix6d> eigen_decomposition(const Matrix6d& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(symmetric);
}

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen_decomposition(
    const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric);
}

Eigen::Vector3d solve_symmetric(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) {
  return a.ldlt().solve(b);
}

Vector6d solve_symmetric(const Matrix6d& a, const Vector6d& b) { return a.ldlt().solve(b); }

Matrix6d solve_symmetric(const Matrix6d& a, const Matrix6d& b) { return a.ldlt().solve(b); }

Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.ldlt().solve(b);
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.ldlt().solve(b);
}

std::optional<Eigen::VectorXd> solve_positive_definite(const Eigen::MatrixXd& a,
                                                       const Eigen::VectorXd& b) {
  const Eigen::LLT<Eigen::MatrixXd> factor(a);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return factor.solve(b);
}

}  // namespace relief
