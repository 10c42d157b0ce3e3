#pragma once

#include <vector>

#include <Eigen/Core>

#include "registration/calibration/estimation/calibration_sums.h"

namespace relief::registration {

/// A quadratic function c^T A c + 2 b^T c of coefficients c, but for a constant.
struct ReducedSum {
  Eigen::MatrixXd matrix;    ///< A
  Eigen::VectorXd gradient;  ///< b

  explicit ReducedSum(Eigen::Index size = 0)
      : matrix(Eigen::MatrixXd::Zero(size, size)), gradient(Eigen::VectorXd::Zero(size)) {}

  /// The same of parameters, each of which is added to the coefficients in its list.
  ReducedSum by_parameters(const std::vector<std::vector<Eigen::Index>>& coefficients) const;

  /// By how much parameters lower the function.
  double fall(const Eigen::VectorXd& parameters) const {
    return -parameters.dot(matrix * parameters + 2.0 * gradient);
  }
};

/// The poses that minimise a sum, as functions of the coefficients c: offset + slope c.
struct EliminatedPoses {
  Eigen::VectorXd offset;
  Eigen::MatrixXd slope;

  EliminatedPoses() = default;
  /// The first `poses` unknowns of the sum are those of poses.
  EliminatedPoses(const QuadraticSum& sum, Eigen::Index poses);

  /// A sum with the poses put in.
  ReducedSum reduce(const QuadraticSum& sum) const;
};

}  // namespace relief::registration
