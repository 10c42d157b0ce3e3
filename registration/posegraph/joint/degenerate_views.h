#pragma once

#include <cstddef>
#include <vector>

#include "registration/pairwise/degenerate_directions.h"
#include "registration/pairwise/shared_surface.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/pair_fit.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What both views of a pair show, as it holds either view.
struct PairConstraint {
  std::size_t a = 0, b = 0;
  std::vector<SharedConstraintSum> of_views;  ///< Of a, and of b, each about its own centre.

  PairConstraint() = default;
  /// `shared`: in the world frame.
  PairConstraint(const std::vector<ViewSurface>& surfaces,
                 const std::vector<RigidMotion>& world_from_view, std::size_t a, std::size_t b,
                 const SharedSurface& shared);
};

/// The motions along which the relief that each view shares with all others is less than a fifth of
/// what holds it. The rest is noise: refined poses drift along such motions. None of views without
/// a pair.
MotionsOfViews degenerate_directions_of_views(std::size_t views,
                                              const std::vector<PairConstraint>& pairs);

/// `refined` without what it moved the view by along `motions` since `start`.
RigidMotion without_drift(const ViewSurface& surface, const RigidMotion& start,
                          const RigidMotion& refined,
                          const std::vector<DegenerateDirection>& motions);

}  // namespace relief::registration
