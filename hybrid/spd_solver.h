#pragma once

#include <memory>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace relief {

/// How a sparse symmetric positive definite system is solved.
enum class Solver {
  kConjugateGradients,  ///< Preconditioned by the Cholesky factors of the blocks of each unknown.
  kCholesky,            ///< One supernodal factorisation of the whole (CHOLMOD): the reference.
};

struct SpdSolverOptions {
  Solver kind = Solver::kConjugateGradients;
  int blocks = 1;            ///< The unknowns come in this many blocks of equal size.
  int max_iterations = 500;  ///< Conjugate gradients: steps after which they give up.
  int threads = 0;           ///< 0: one per core.
};

struct SpdSolve {
  bool converged = false;
  int iterations = 0;  ///< Conjugate gradient steps; 1 for a factorisation.
};

/// Solves symmetric positive definite systems that share a sparsity pattern. Keeps orderings and
/// factors from one solve to the next.
class SpdSolver {
 public:
  explicit SpdSolver(const SpdSolverOptions& options);
  ~SpdSolver();

  /// `lower` is the lower triangle of the matrix. Conjugate gradients start from `y`; the solution
  /// is left there. They stop when the preconditioned residual is below `tolerance` times that of
  /// y = 0. Factors of an earlier matrix serve as preconditioner while they do well.
  SpdSolve solve(const Eigen::SparseMatrix<double>& lower, const Eigen::VectorXd& rhs,
                 Eigen::VectorXd& y, double tolerance);

 private:
  struct Factors;
  SpdSolve solve_directly(const Eigen::SparseMatrix<double>& lower, const Eigen::VectorXd& rhs,
                          Eigen::VectorXd& y);
  SpdSolve iterate(const Eigen::SparseMatrix<double>& lower, const Eigen::VectorXd& rhs,
                   Eigen::VectorXd& y, double tolerance, int max_iterations) const;

  SpdSolverOptions options_;
  std::unique_ptr<Factors> factors_;
};

}  // namespace relief
