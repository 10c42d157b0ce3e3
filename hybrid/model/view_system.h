#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "hybrid/model/view_problem.h"

namespace relief::hybrid {

/// The normal equations of a view: A y = b with y = [x; b_u; b_v], or y = x without a bias. The
/// sparsity pattern is found once, weights are put in as often as needed.
class ViewSystem {
 public:
  /// `problem` must outlive the system.
  ViewSystem(const ViewProblem& problem, bool with_bias);

  void assemble(const ViewWeights& weights);

  /// The lower triangle of A, symmetric and positive definite.
  const Eigen::SparseMatrix<double>& lower() const { return lower_; }
  const Eigen::VectorXd& rhs() const { return rhs_; }
  /// Unknowns of one kind; there are 1 or 3 such blocks.
  Eigen::Index block_size() const { return samples_; }
  int blocks() const { return with_bias_ ? 3 : 1; }

 private:
  static constexpr int kTerms = 4;  // unknowns of one slope constraint
  struct Row {
    Eigen::Index unknown[kTerms];
    double coefficient[kTerms];
  };
  Row row_of(int axis, std::size_t i) const;
  int terms() const { return with_bias_ ? 4 : 2; }
  void find_pattern();
  std::uint32_t slot(Eigen::Index i, Eigen::Index j) const;
  void add_slopes(const ViewWeights& weights);
  void add_bias_prior(const ViewWeights& weights);

  const ViewProblem& problem_;
  bool with_bias_;
  Eigen::Index samples_;
  std::vector<std::uint32_t> number_;                     // of a movable sample, by padded index
  std::vector<std::array<std::uint32_t, 2>> neighbours_;  // between which the bias is smooth
  Eigen::SparseMatrix<double> lower_;
  Eigen::VectorXd rhs_;
  std::vector<std::uint32_t> slope_slots_;   // places in `lower_` of every product of two terms
  std::vector<std::uint32_t> smooth_slots_;  // off-diagonal places of the bias differences
};

}  // namespace relief::hybrid
