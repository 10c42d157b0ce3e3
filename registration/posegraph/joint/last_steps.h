#pragma once

#include <vector>

#include "registration/pairwise/search_schedule.h"
#include "registration/posegraph/joint/joint_refinement.h"
#include "registration/posegraph/joint/view_clusters.h"
#include "registration/posegraph/view_graph.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/align_options.h"

namespace relief::registration {

/// Pairs that overlap, and the strongest of them, by which poses are refined.
struct LinkedPairs {
  const std::vector<ViewPair>& all;
  std::vector<ViewPair> strongest;
};

/// The last steps of refine_jointly(), from the poses of `result`, which tells the views that are
/// held: with all samples of the strongest pairs. Sets the poses, their covariances, and how all
/// pairs fit. Normal maps are matched where either view is `nearly_degenerate`. Steps leave the
/// motions `kept_motions` alone (empty: none), which `result` tells then. `most_steps` is
/// PoseGraphRefinementOptions::max_iterations.
///
/// Returns what all pairs share at these poses.
std::vector<PairConstraint> take_last_steps(const std::vector<ViewSurface>& surfaces,
                                            const LinkedPairs& pairs, const SearchLevel& level,
                                            const std::vector<bool>& nearly_degenerate,
                                            MotionsOfViews kept_motions, int most_steps,
                                            const JointRefinementOptions& options,
                                            JointRefinement& result);

}  // namespace relief::registration
