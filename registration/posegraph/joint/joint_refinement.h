#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "registration/pairwise/correspondences.h"
#include "registration/pairwise/degenerate_directions.h"
#include "registration/posegraph/pairs/pair_fit.h"
#include "registration/posegraph/refinement/pose_covariance.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/align_options.h"
#include "relief/registration/align_views.h"
#include "relief/registration/loop_closure.h"
#include "relief/registration/pair_fit.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

struct JointRefinement {
  std::vector<RigidMotion> world_from_view;
  RefinementTermination termination = RefinementTermination::kNoOverlap;
  int iterations = 0;      ///< Renewals of the correspondences over all levels.
  double last_motion = 0;  ///< Largest motion of a sample by the last one [unit].
  double rms = 0.0;        ///< Over all correspondences [unit].
  std::vector<PairFit> pairs;
  /// For each view the smallest index of a view that pairs link it to. Groups do not see each
  /// other: within each, poses are relative to its held view.
  std::vector<std::size_t> group;
  /// Views that did not move: the fixed ones and, in groups without any, the first.
  std::vector<bool> held;
  /// Covariance of each pose as tangent (rotation [rad], translation [unit]) about the view's
  /// centre in world axes; zero for held views. See PoseGraphSystem::covariance().
  std::vector<Matrix6d> pose_covariance;
  std::vector<RigidTangent> pose_std;  ///< The roots of their diagonals.
  /// Of all poses together, between views of up to 32 alone; not kept in a UnitStore.
  PoseCovariance joint_covariance;
  /// For each view, motions along which it keeps its starting pose, as nothing but noise holds it.
  MotionsOfViews kept_motions;
  std::vector<SolverSummary> solves;  ///< In their order.
  std::vector<LoopClosure> loops;     ///< Of the pairs, the least explained first.
};

/// What the refinement may do with a view.
enum class ViewRole {
  kFree,      ///< Its pose is refined.
  kFixed,     ///< Its pose stays, to the bit; others are aligned to it.
  kExcluded,  ///< It has no meaningful pose: it pairs with none and stays.
};

/// Refines all poses at once: minimises the robust point-to-plane distances of all overlapping
/// pairs, both ways (R3), and renews the correspondences until the poses stand still. Of many views
/// only the largest overlaps of each take part. Along motions of which nothing but noise tells,
/// views keep the poses given. The only error is kInterrupted.
Result<JointRefinement> refine_jointly(const std::vector<ViewSurface>& surfaces,
                                       const std::vector<RigidMotion>& world_from_view,
                                       const std::vector<ViewRole>& roles,
                                       const JointRefinementOptions& options = {},
                                       const Progress& progress = {});

}  // namespace relief::registration
