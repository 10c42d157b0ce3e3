#include "registration/calibration/estimation/reduced_sum.h"

#include <cstddef>

#include "scan/base/linear_algebra.h"

namespace relief::registration {

namespace {

// What keeps poses finite that nothing determines, relative to the precision of a component: far
// above rounding (2e-16) and below all evidence.
constexpr double kRelativePrior = 1e-12;

}  // namespace

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

EliminatedPoses::EliminatedPoses(const QuadraticSum& sum, Eigen::Index poses) {
  const Eigen::Index coefficients = sum.gradient.size() - poses;
  Eigen::MatrixXd matrix = sum.matrix.topLeftCorner(poses, poses);
  matrix.diagonal() *= 1.0 + kRelativePrior;
  matrix.diagonal().array() += 1e-300;
  Eigen::MatrixXd right(poses, 1 + coefficients);
  right << sum.gradient.head(poses), sum.matrix.topRightCorner(poses, coefficients);
  const Eigen::MatrixXd found = solve_symmetric(matrix, right);
  offset = -found.col(0);
  slope = -found.rightCols(coefficients);
}

ReducedSum EliminatedPoses::reduce(const QuadraticSum& sum) const {
  const Eigen::Index poses = offset.size(), coefficients = slope.cols();
  const auto pp = sum.matrix.topLeftCorner(poses, poses);
  const auto pc = sum.matrix.topRightCorner(poses, coefficients);
  const Eigen::MatrixXd half = pp * slope + pc;
  const Eigen::MatrixXd cross = slope.transpose() * pc;
  ReducedSum reduced;
  reduced.matrix = slope.transpose() * half + cross.transpose() +
                   sum.matrix.bottomRightCorner(coefficients, coefficients);
  reduced.gradient = sum.gradient.tail(coefficients) +
                     slope.transpose() * sum.gradient.head(poses) + half.transpose() * offset;
  return reduced;
}

}  // namespace relief::registration
