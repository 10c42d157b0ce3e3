#pragma once

#include <cstddef>
#include <vector>

#include "registration/pairwise/correspondences.h"
#include "registration/pairwise/search_schedule.h"
#include "registration/posegraph/joint/joint_solver.h"
#include "registration/posegraph/view_graph.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/align_options.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// How to search for correspondences of so many pairs of views at a level, `fewest` at least of
/// each direction. Hundreds of views have thousands of pairs: each then needs fewer, for the same
/// number per view.
CorrespondenceOptions search_at(const SearchLevel& level, std::size_t pairs, int fewest,
                                const JointRefinementOptions& options);

/// Matches pairs of views at poses, one direction of a pair at a time. All that is given has to
/// outlive it.
class PairMatcher {
 public:
  /// Normal maps, at resolution `signal_level`, are matched where either view is
  /// `nearly_degenerate`.
  PairMatcher(const std::vector<ViewSurface>& surfaces,
              const std::vector<RigidMotion>& world_from_view, const std::vector<ViewPair>& pairs,
              const CorrespondenceOptions& search, int signal_level,
              const std::vector<bool>& nearly_degenerate)
      : surfaces_(surfaces),
        world_from_view_(world_from_view),
        pairs_(pairs),
        search_(search),
        signal_level_(signal_level),
        nearly_degenerate_(nearly_degenerate) {}

  std::size_t size() const { return 2 * pairs_.size(); }  ///< Directed pairs.
  bool by_normal_maps(std::size_t i) const {
    return nearly_degenerate_[pairs_[i / 2].a] || nearly_degenerate_[pairs_[i / 2].b];
  }

  /// The matches of directed pair i, see source_of(). Motions that neither the normal maps nor the
  /// geometry determine get no weight from the normal maps.
  DirectedMatches operator()(std::size_t i) const;

 private:
  const std::vector<ViewSurface>& surfaces_;
  const std::vector<RigidMotion>& world_from_view_;
  const std::vector<ViewPair>& pairs_;
  CorrespondenceOptions search_;
  int signal_level_;
  const std::vector<bool>& nearly_degenerate_;
};

}  // namespace relief::registration
