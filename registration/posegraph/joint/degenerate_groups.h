#pragma once

#include <cstddef>
#include <vector>

#include "registration/pairwise/degenerate_directions.h"
#include "registration/posegraph/joint/view_clusters.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/pair_fit.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Views, or one view, that nothing but noise holds to the others along some motions.
struct DegenerateGroup {
  std::vector<std::size_t> views;            ///< Ascending; none of them is held.
  std::vector<DegenerateDirection> motions;  ///< Of the views as one; world frame.
};

/// The groups for which the relief shared with all other views is, along some motion, less than a
/// fifth of what holds them. The rest is noise: refined poses drift along such motions. Smaller
/// ones first; of any two, one holds the other or they share no view. `linked`: for each view the
/// smallest index of a view that pairs link it to; `held`: the views that do not move.
std::vector<DegenerateGroup> degenerate_groups(const std::vector<PairConstraint>& pairs,
                                               const std::vector<ViewSurface>& surfaces,
                                               const std::vector<RigidMotion>& world_from_view,
                                               const std::vector<std::size_t>& linked,
                                               const std::vector<bool>& held);

/// What holds the groups to all other views along their motions, of all groups together.
MotionConstraint constraint_along_motions(const std::vector<DegenerateGroup>& groups,
                                          const std::vector<PairConstraint>& pairs);

/// What of a group's motion since the start is drift.
enum class Drift {
  kAlongMotions,  ///< What lies along the group's motions.
  kAll,           ///< All of it: it led to where the group's motions say little.
};

/// Removes what the views of each group moved by on average since `start`, from all of them alike.
/// Views that a smaller group holds (kAlongMotions: along the same motion) follow that group alone.
/// Returns for each view the motions of its groups, without those nearly the same.
MotionsOfViews remove_drift(const std::vector<DegenerateGroup>& groups, Drift drift,
                            const std::vector<ViewSurface>& surfaces,
                            const std::vector<RigidMotion>& start,
                            std::vector<RigidMotion>& world_from_view);

}  // namespace relief::registration
