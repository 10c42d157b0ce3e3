#pragma once

#include <vector>

#include "registration/pairwise/correspondences.h"
#include "registration/posegraph/view_graph.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// How well views fit each other.
struct PairwiseFit {
  double overlap = 0.0;   ///< Sum over the directed pairs of the part that both views see.
  double distance = 0.0;  ///< Median distance along the target's lines of sight, mean of the pairs
                          ///< [unit]; samples without a counterpart are left out.
};

PairwiseFit measure_fit(const std::vector<ViewSurface>& surfaces,
                        const std::vector<RigidMotion>& world_from_view,
                        const std::vector<ViewPair>& pairs, const CorrespondenceOptions& search);

}  // namespace relief::registration
