#pragma once

#include <vector>

#include "registration/posegraph/loops/pair_motion.h"
#include "registration/posegraph/refinement/pose_graph_refinement.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/loop_closure.h"
#include "relief/registration/pair_fit.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Where views stand, as loop closures need it.
struct PlacedView {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Of its samples, world frame [unit].
  double radius = 0.0;                               ///< [unit]
};

/// The closures of the smallest cycles (smallest_cycles()) of the pairs that have a motion of their
/// own, those with the largest ratio first. `overlaps`: of pairs, by which cycles are chosen; pairs
/// without an own motion are left out. `centre`: that of the motions. `variance_inflation`: of the
/// scatter of patches.
std::vector<LoopClosure> close_loops(const std::vector<PlacedView>& views,
                                     const std::vector<PairMotion>& motions,
                                     const std::vector<PairFit>& overlaps,
                                     const Eigen::Vector3d& centre, double variance_inflation);

/// The loop closures of a refinement: of its last step, at the poses that it gave.
std::vector<LoopClosure> loop_closures(const std::vector<ViewSurface>& surfaces,
                                       const std::vector<RigidMotion>& world_from_view,
                                       const PoseGraphLastStep& last,
                                       const std::vector<PairFit>& fits);

}  // namespace relief::registration
