#include "registration/calibration/estimation/reduced_sum.h"

#include <cstddef>

namespace relief::registration {

ReducedSum ReducedSum::by_parameters(
    const std::vector<std::vector<Eigen::Index>>& coefficients) const {
  const auto count = static_cast<Eigen::Index>(coefficients.size());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(matrix.rows(), count);
  ReducedSum result(count);
  for (Eigen::Index p = 0; p < count; ++p) {
    for (const Eigen::Index c : coefficients[static_cast<std::size_t>(p)]) {
      columns.col(p) += matrix.col(c);
      result.gradient[p] += gradient[c];
    }
  }
  for (Eigen::Index p = 0; p < count; ++p)
    for (const Eigen::Index c : coefficients[static_cast<std::size_t>(p)])
      result.matrix.row(p) += columns.row(c);
  return result;
}

}  // namespace relief::registration
