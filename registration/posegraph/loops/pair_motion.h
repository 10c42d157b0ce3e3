#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "registration/posegraph/refinement/pair_information.h"
#include "registration/posegraph/refinement/pose_graph_refinement.h"
#include "relief/registration/pair_fit.h"
#include "relief/scan/page_allocator.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The motion of view a relative to view b that the pair's own residuals ask for, relative to what
/// all pairs together gave: a tangent about the centre of PoseGraphLastStep (R16).
struct PairMotion {
  std::size_t a = 0, b = 0;  ///< a < b.
  RigidTangent motion = RigidTangent::Zero();
  /// What the residuals on each patch of the surface move it by, in ascending order of `patch`.
  PagedVector<PatchScore> influence;
  Matrix6d independent = Matrix6d::Zero();  ///< Covariance that no patch has part in.
};

/// The own motions of all pairs of the last step, in its order, without those that know nothing.
/// `fits`: pairs whose degenerate directions stay as in the joint solution; in any order.
std::vector<PairMotion> motions_of_pairs(const PoseGraphLastStep& last,
                                         const std::vector<PairFit>& fits);

}  // namespace relief::registration
