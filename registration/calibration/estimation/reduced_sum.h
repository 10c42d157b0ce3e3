#pragma once

#include <vector>

#include <Eigen/Core>

namespace relief::registration {

/// For each parameter the sum of the columns of the coefficients that it adds to.
Eigen::MatrixXd columns_by_parameters(const Eigen::MatrixXd& columns,
                                      const std::vector<std::vector<Eigen::Index>>& coefficients);

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

}  // namespace relief::registration
