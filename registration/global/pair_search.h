#pragma once

#include <optional>
#include <vector>

#include "registration/global/features/local_features.h"
#include "registration/global/features/resampled_view.h"
#include "registration/surface/view_surface.h"
#include "registration/verification/pose_evidence.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// A view as coarse alignment sees it.
struct CoarseView {
  const ViewSurface* surface = nullptr;  ///< Outlives this.
  ResampledView points;
  LocalFeatures features;
};

/// Resamples and describes a view; without samples it has no points.
CoarseView prepare_coarse_view(const ViewSurface& surface, const CoarseScale& scale);

/// A relative pose that two views may have.
struct PoseHypothesis {
  RigidMotion b_from_a = RigidMotion::Identity();
  PoseEvidence evidence;
};

struct PairSearchOptions {
  JudgeOptions judge;  ///< Its association is that of ICP as well.
  /// Sets of consistent matches that are looked at, at most; > 0. Bounds the time.
  int seeds = 60;
  /// Poses that ICP refines, at most; > 0. Bounds the time.
  int candidates = 8;
};

/// Relative poses of two views without any guess, refined by ICP and judged, the best overlap
/// first: from matching features, sets of mutually consistent matches, and a robust motion for
/// each. All differ by more than ICP would move them. Most are wrong: see `plausible`.
std::vector<PoseHypothesis> search_pair(const CoarseView& a, const CoarseView& b,
                                        const CoarseScale& scale,
                                        const PairSearchOptions& options = {});

/// The motions but the identity that map a view onto itself as well as `limits` ask, with their
/// inverses, the best overlap first: partial symmetries (Mitra, Guibas and Pauly 2006), as of
/// bowls, plain shapes and facades.
std::vector<RigidMotion> partial_symmetries(const CoarseView& view, const CoarseScale& scale,
                                            const VerificationThresholds& limits,
                                            const PairSearchOptions& options = {});

/// The other relative poses of two views that follow from the partial symmetries of either: the
/// samples of a symmetric view may as well be those of the second place. Refined by ICP and judged,
/// the best overlap first.
std::vector<PoseHypothesis> alternative_poses(const ViewSurface& a, const ViewSurface& b,
                                              const RigidMotion& b_from_a,
                                              const std::vector<RigidMotion>& a_symmetries,
                                              const std::vector<RigidMotion>& b_symmetries,
                                              const CoarseScale& scale,
                                              const JudgeOptions& judge = {});

/// How far around poses that matches lead to refine_hypothesis() looks for partners [unit].
double refinement_reach(const CoarseScale& scale);

/// A starting pose refined by a quick ICP, with the association of `judge`, and judged.
PoseHypothesis refine_hypothesis(const ViewSurface& a, const ViewSurface& b,
                                 const RigidMotion& b_from_a, double search_distance,
                                 const JudgeOptions& judge = {});

/// Where two views come to rest from a pose that may be theirs, judged. Nothing where they leave it
/// for another one.
std::optional<PoseHypothesis> confirm_pose(const ViewSurface& a, const ViewSurface& b,
                                           const RigidMotion& b_from_a, const CoarseScale& scale,
                                           const JudgeOptions& judge = {});

/// Whether two relative poses of a view put its points at the same places, to `tolerance` [unit].
bool same_pose(const ViewSurface& view, const RigidMotion& x, const RigidMotion& y,
               double tolerance);

}  // namespace relief::registration
