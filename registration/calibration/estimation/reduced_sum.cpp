#include "registration/calibration/estimation/reduced_sum.h"

#include <cstddef>

namespace relief::registration {

Eigen::MatrixXd columns_by_parameters(const Eigen::MatrixXd& columns,
                                      const std::vector<std::vector<Eigen::Index>>& coefficients) {
  Eigen::MatrixXd sums =
      Eigen::MatrixXd::Zero(columns.rows(), static_cast<Eigen::Index>(coefficients.size()));
  for (std::size_t p = 0; p < coefficients.size(); ++p)
    for (const Eigen::Index c : coefficients[p])
      sums.col(static_cast<Eigen::Index>(p)) += columns.col(c);
  return sums;
}

ReducedSum ReducedSum::by_parameters(
    const std::vector<std::vector<Eigen::Index>>& coefficients) const {
  ReducedSum result;
  const Eigen::MatrixXd columns = columns_by_parameters(matrix, coefficients);
  result.matrix = columns_by_parameters(columns.transpose(), coefficients).transpose();
  result.gradient = columns_by_parameters(gradient.transpose(), coefficients).transpose();
  return result;
}

}  // namespace relief::registration
