#pragma once

#include <optional>
#include <vector>

#include "registration/coarse/view_groups.h"
#include "registration/pose_evidence.h"
#include "registration/view_surface.h"
#include "scan/progress.h"
#include "scan/result.h"
#include "scan/rigid_motion.h"

namespace relief {

struct PlaceViewsOptions {
  Association association = Association::kAuto;
  PlausibleEvidence limits;  ///< What links of views must show.
  /// Two ways of joining views are told apart when the weaker has less than this part of the
  /// support of the stronger; in (0, 1].
  double ambiguity = 0.5;
  /// Pairs of views that are searched, per view, at most; > 0. Small sets are searched in full.
  int pairs_per_view = 12;
  bool search = true;  ///< Whether to look for poses that are not given, by shape.
  int threads = 0;     ///< 0: one per core. Never changes the result.
};

/// What is known of a view's pose before.
struct PosePrior {
  std::optional<RigidMotion> world_from_view;
  bool known = false;  ///< Exact, not a guess.
};

/// Groups of views that fit together, from given poses and, where these do not hold, from shape
/// alone: pairs of similar views are searched for relative poses until all views are in one group
/// or no more pairs are worth it. Views without samples stay alone. The only error is kInterrupted.
Result<ViewGroups> place_views(const std::vector<ViewSurface>& surfaces,
                               const std::vector<PosePrior>& priors,
                               const PlaceViewsOptions& options = {},
                               const Progress& progress = {});

}  // namespace relief
