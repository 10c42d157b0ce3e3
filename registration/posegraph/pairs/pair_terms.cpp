#include "registration/posegraph/pairs/pair_terms.h"

#include <array>
#include <cmath>

#include "registration/pairwise/normal_equations.h"
#include "registration/pairwise/robust.h"
#include "scan/base/robust_scales.h"

namespace relief::registration {

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
