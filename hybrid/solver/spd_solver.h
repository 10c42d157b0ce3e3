#pragma once

#include <memory>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace relief::hybrid {

/// Solves sparse symmetric positive definite systems that share a sparsity pattern, by supernodal
/// factorisation (CHOLMOD). Keeps the ordering from one matrix to the next.
class SpdSolver {
 public:
  SpdSolver();
  ~SpdSolver();

  /// `lower` is the lower triangle of the matrix. False: it is not positive definite.
  bool factorise(const Eigen::SparseMatrix<double>& lower);
  /// With the last matrix factorised.
  Eigen::VectorXd solve(const Eigen::VectorXd& rhs) const;

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

}  // namespace relief::hybrid
