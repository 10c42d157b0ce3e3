#include "registration/posegraph/pair_terms.h"

#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "registration/pairwise/normal_equations.h"
#include "registration/pairwise/robust.h"
#include "scan/base/robust_scales.h"

namespace relief::registration {

namespace {

// Directions of the matrix that are weaker than the strongest by this are rounding: 45 times the
// spacing of double precision, 2.2e-16.
constexpr double kLeastEigenvalue = 1e-14;

}  // namespace

CompressedTerms compress(const NormalEquations& sum, double losses) {
  // Free of units: rotations count as much as translations.
  if (!sum.matrix.allFinite() || !sum.gradient.allFinite() || !std::isfinite(losses)) {
    // Without this, comparisons below would take the pair for one that says nothing.
    CompressedTerms unusable;
    unusable.residuals.setConstant(std::numeric_limits<double>::quiet_NaN());
    return unusable;
  }
  const Vector6d diagonal = sum.matrix.diagonal();
  const Vector6d scale =
      (diagonal.array() > 0.0).select(diagonal.cwiseMax(1e-300).cwiseSqrt(), Vector6d::Ones());
  const Vector6d inverse = scale.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(inverse.asDiagonal() * sum.matrix *
                                                      inverse.asDiagonal());
  const Vector6d gradient = inverse.cwiseProduct(sum.gradient);
  CompressedTerms terms;
  for (int k = 0; k < 6; ++k) {
    const double value = eigen.eigenvalues()[k];
    if (!(value > kLeastEigenvalue * eigen.eigenvalues()[5])) continue;
    const Vector6d direction = eigen.eigenvectors().col(k);
    terms.residuals[k] = direction.dot(gradient) / std::sqrt(value);
    terms.derivative.row(k) = (std::sqrt(value) * scale.cwiseProduct(direction)).transpose();
  }
  terms.residuals[6] = std::sqrt(std::max(0.0, losses - terms.residuals.squaredNorm()));
  return terms;
}

CompressedTerms PairTerms::compress(const RigidMotion& target_from_source) const {
  NormalEquations sum;
  CauchyLosses of_planes(kCauchyScale);
  CauchyLosses of_normals(std::sqrt(2.0) * kCauchyScale);  // Of two residuals at once.
  RigidTangent j;
  for (const PlaneResidual& plane : planes) {
    const double r = plane.evaluate(target_from_source, j);
    sum.add(j, r, of_planes.add(r * r));
  }
  std::array<RigidTangent, 2> of_both;
  for (const NormalResidual& normal : normals) {
    const Eigen::Vector2d r = normal.evaluate(target_from_source, of_both);
    const double weight = of_normals.add(r.squaredNorm());
    for (std::size_t k = 0; k < 2; ++k)
      sum.add(of_both[k], r[static_cast<Eigen::Index>(k)], weight);
  }
  return registration::compress(sum, of_planes.sum() + of_normals.sum());
}

}  // namespace relief::registration
