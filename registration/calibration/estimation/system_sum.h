#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/estimation/reduced_sum.h"
#include "registration/calibration/estimation/system_layout.h"
#include "registration/posegraph/refinement/block_sandwich.h"

namespace relief::registration {

/// Sums over pairs, a quadratic function of the unknowns of a SystemLayout: x^T A x + 2 b^T x +
/// `squares`. Of the poses only views of a pair share blocks of A, so memory grows as the number of
/// pairs.
struct SystemSum {
  SymmetricBlocks poses;         ///< A of the poses, by view. Held views have none.
  Eigen::MatrixXd cross;         ///< A of poses and coefficients.
  Eigen::MatrixXd coefficients;  ///< A of the coefficients.
  Eigen::VectorXd pose_gradient, coefficient_gradient;  ///< b.
  double squares = 0.0;

  SystemSum() = default;
  explicit SystemSum(const SystemLayout& layout);

  /// Adds one fold of a pair.
  void add(const PairSums& pair, std::size_t fold, const Sensors& sensors,
           const SystemLayout& layout);
  SystemSum& operator+=(const SystemSum& other);
};

/// The poses that minimise a sum, as functions of the coefficients c: offset + slope c. Both are 0
/// where rounding leaves A without Cholesky factors.
class EliminatedPoses {
 public:
  EliminatedPoses() = default;
  EliminatedPoses(const SystemSum& sum, const SystemLayout& layout);

  /// A sum of the same layout with the poses put in.
  ReducedSum reduce(const SystemSum& sum, const SystemLayout& layout) const;

  const Eigen::MatrixXd& slope() const { return slope_; }

 private:
  Eigen::VectorXd offset_;
  Eigen::MatrixXd slope_;
};

/// The variance of each component of the poses when the coefficients are known: the diagonal of
/// A^-1 of the poses. NaN where rounding leaves A without Cholesky factors.
Eigen::VectorXd variances_of_poses(const SystemSum& sum, const SystemLayout& layout);

/// Adds the common_motion() of a pair, by the coefficients. It has no gradient.
void add_common_motion(const PairSums& pair, const Sensors& sensors, const SystemLayout& layout,
                       ReducedSum& all);

}  // namespace relief::registration
