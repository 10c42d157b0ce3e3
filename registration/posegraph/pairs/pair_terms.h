#pragma once

#include <span>

#include "registration/pairwise/degenerate_directions.h"
#include "registration/pairwise/normal_equations.h"
#include "registration/pairwise/normal_maps/normal_residual.h"
#include "registration/pairwise/plane_residual.h"
#include "registration/posegraph/pairs/quadratic_residuals.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Seven residuals that stand for all terms of a directed pair of views at a pose of the source
/// relative to the target: the sum of squares of `residuals` is that of the losses,
/// 2 D^T r its gradient and D^T D the Gauss-Newton matrix of reweighted least squares, with D the
/// derivative by a motion of the source as in PlaneResidual.
using CompressedTerms = QuadraticResiduals<6>;

/// The seven residuals of summed terms, `losses` the sum of what they cost (R6).
inline CompressedTerms compress(const NormalEquations& sum, double losses) {
  return quadratic_residuals<6>(sum.matrix, sum.gradient, losses);
}

/// All terms of the joint refinement between one view's samples and another's surface: (R3) and
/// (R9), with the Cauchy loss.
struct PairTerms {
  std::span<const PlaneResidual> planes;
  std::span<const NormalResidual> normals;

  /// All of them at a relative pose, exactly: they depend on six parameters only, whatever their
  /// number (R6).
  CompressedTerms compress(const RigidMotion& target_from_source) const;
};

}  // namespace relief::registration
