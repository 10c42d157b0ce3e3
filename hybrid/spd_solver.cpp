#include "hybrid/spd_solver.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>

#include <Eigen/CholmodSupport>

#include "scan/parallel.h"

namespace relief {

namespace {

using Factor = Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>, Eigen::Lower>;

// An old preconditioner that needs more steps than this costs more than a new one.
constexpr int kStalePreconditioner = 20;

}  // namespace

// The Cholesky factors of the diagonal blocks of a matrix: its block Jacobi preconditioner, or,
// with one block, its inverse.
struct SpdSolver::Factors {
  std::deque<Factor> blocks;
  bool analysed = false, usable = false;

  bool factorise(const Eigen::SparseMatrix<double>& lower, int threads) {
    const Eigen::Index size = lower.rows() / static_cast<Eigen::Index>(blocks.size());
    std::atomic<bool> ok{true};
    parallel_for(blocks.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) {
        const auto offset = static_cast<Eigen::Index>(b) * size;
        const Eigen::SparseMatrix<double> block = lower.block(offset, offset, size, size);
        if (!analysed) {
          blocks[b].cholmod().print = 0;
          blocks[b].analyzePattern(block);
        }
        blocks[b].factorize(block);
        if (blocks[b].info() != Eigen::Success) ok = false;
      }
    });
    analysed = true;
    return usable = ok;
  }

  Eigen::VectorXd apply(const Eigen::VectorXd& residual, int threads) {
    Eigen::VectorXd result(residual.size());
    const Eigen::Index size = residual.size() / static_cast<Eigen::Index>(blocks.size());
    parallel_for(blocks.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) {
        const auto offset = static_cast<Eigen::Index>(b) * size;
        const Eigen::VectorXd part = residual.segment(offset, size);
        result.segment(offset, size) = blocks[b].solve(part);
      }
    });
    return result;
  }
};

SpdSolver::SpdSolver(const SpdSolverOptions& options)
    : options_(options), factors_(std::make_unique<Factors>()) {
  const bool whole = options.kind == Solver::kCholesky;
  factors_->blocks.resize(whole ? 1 : static_cast<std::size_t>(options.blocks));
}

SpdSolver::~SpdSolver() = default;

SpdSolve SpdSolver::solve(const Eigen::SparseMatrix<double>& lower, const Eigen::VectorXd& rhs,
                          Eigen::VectorXd& y, double tolerance) {
  if (options_.kind == Solver::kCholesky) return solve_directly(lower, rhs, y);
  SpdSolve attempt;
  if (factors_->usable) {
    attempt =
        iterate(lower, rhs, y, tolerance, std::min(kStalePreconditioner, options_.max_iterations));
    if (attempt.converged) return attempt;
  }
  if (!factors_->factorise(lower, options_.threads)) return attempt;
  SpdSolve solve = iterate(lower, rhs, y, tolerance, options_.max_iterations);
  solve.iterations += attempt.iterations;
  return solve;
}

SpdSolve SpdSolver::solve_directly(const Eigen::SparseMatrix<double>& lower,
                                   const Eigen::VectorXd& rhs, Eigen::VectorXd& y) {
  if (!factors_->factorise(lower, options_.threads)) return {};
  y = factors_->apply(rhs, options_.threads);
  return {y.allFinite(), 1};
}

// Preconditioned conjugate gradients (Hestenes and Stiefel 1952). All sums run in one thread: the
// result does not depend on the number of threads.
SpdSolve SpdSolver::iterate(const Eigen::SparseMatrix<double>& lower, const Eigen::VectorXd& rhs,
                            Eigen::VectorXd& y, double tolerance, int max_iterations) const {
  const auto matrix = lower.selfadjointView<Eigen::Lower>();
  const double goal = tolerance * tolerance * rhs.dot(factors_->apply(rhs, options_.threads));
  Eigen::VectorXd residual = rhs - matrix * y;
  Eigen::VectorXd preconditioned = factors_->apply(residual, options_.threads);
  Eigen::VectorXd direction = preconditioned;
  double energy = residual.dot(preconditioned);
  SpdSolve solve;
  while (energy > goal && solve.iterations < max_iterations) {
    const Eigen::VectorXd image = matrix * direction;
    const double step = energy / direction.dot(image);
    if (!std::isfinite(step)) return solve;
    y += step * direction;
    residual -= step * image;
    preconditioned = factors_->apply(residual, options_.threads);
    const double next = residual.dot(preconditioned);
    direction = preconditioned + (next / energy) * direction;
    energy = next;
    ++solve.iterations;
  }
  solve.converged = energy <= goal;
  return solve;
}

}  // namespace relief
