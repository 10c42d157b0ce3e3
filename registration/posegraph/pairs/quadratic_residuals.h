#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "scan/base/linear_algebra.h"

namespace relief::registration {

/// N + 1 residuals, linear in N unknowns, whose squares sum to a quadratic function (R6). N may be
/// Eigen::Dynamic.
template <int N>
struct QuadraticResiduals {
  static constexpr int kRows = N == Eigen::Dynamic ? Eigen::Dynamic : N + 1;
  Eigen::Matrix<double, kRows, 1> residuals;
  Eigen::Matrix<double, kRows, N> derivative;

  QuadraticResiduals() : QuadraticResiduals(N == Eigen::Dynamic ? 0 : N) {}
  explicit QuadraticResiduals(Eigen::Index size)
      : residuals(Eigen::Matrix<double, kRows, 1>::Zero(size + 1)),
        derivative(Eigen::Matrix<double, kRows, N>::Zero(size + 1, size)) {}
};

/// The residuals of the function with this matrix and half this gradient at 0, where it is `losses`
/// (R6). Directions that the matrix does not determine, or determines negatively, have no say. Not
/// finite if the sums are not.
template <int N>
QuadraticResiduals<N> quadratic_residuals(const Eigen::Matrix<double, N, N>& matrix,
                                          const Eigen::Matrix<double, N, 1>& gradient,
                                          double losses) {
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  // Directions of the matrix that are weaker than the strongest by this are rounding: 45 times the
  // spacing of double precision, 2.2e-16.
  constexpr double kLeastEigenvalue = 1e-14;
  const Eigen::Index size = gradient.size();
  QuadraticResiduals<N> terms(size);
  if (!matrix.allFinite() || !gradient.allFinite() || !std::isfinite(losses)) {
    // Without this, comparisons below would take the sums for some that say nothing.
    terms.residuals.setConstant(std::numeric_limits<double>::quiet_NaN());
    return terms;
  }
  // Free of units: rotations count as much as translations.
  const Vector diagonal = matrix.diagonal();
  const Vector scale =
      (diagonal.array() > 0.0).select(diagonal.cwiseMax(1e-300).cwiseSqrt(), Vector::Ones(size));
  const Vector inverse = scale.cwiseInverse();
  const auto eigen =
      eigen_decomposition(Matrix(inverse.asDiagonal() * matrix * inverse.asDiagonal()));
  const Vector scaled_gradient = inverse.cwiseProduct(gradient);
  for (Eigen::Index k = 0; k < size; ++k) {
    const double value = eigen.eigenvalues()[k];
    if (!(value > kLeastEigenvalue * eigen.eigenvalues()[size - 1])) continue;
    const Vector direction = eigen.eigenvectors().col(k);
    terms.residuals[k] = direction.dot(scaled_gradient) / std::sqrt(value);
    terms.derivative.row(k) = (std::sqrt(value) * scale.cwiseProduct(direction)).transpose();
  }
  terms.residuals[size] = std::sqrt(std::max(0.0, losses - terms.residuals.squaredNorm()));
  return terms;
}

}  // namespace relief::registration
