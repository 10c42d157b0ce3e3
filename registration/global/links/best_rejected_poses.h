#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "registration/global/pair_search.h"
#include "registration/global/view_groups.h"
#include "registration/surface/view_surface.h"
#include "registration/verification/pose_evidence.h"

namespace relief::registration {

/// For each view the pose nearest to being believed, of all that a search found: what a user is
/// told of a view that finds no place.
class BestRejectedPoses {
 public:
  /// Both must outlive this.
  BestRejectedPoses(const std::vector<ViewSurface>& surfaces, const VerificationThresholds& limits)
      : surfaces_(surfaces), limits_(limits) {}

  /// Keeps for views a and b the pose that deviates least, also of those that are no candidates.
  void add(std::size_t a, std::size_t b, const std::vector<PoseHypothesis>& found);

  /// By view, a pose next to a view of another group: the link that shares most, else what add()
  /// kept.
  std::vector<std::optional<PoseLink>> between_groups(const std::vector<std::size_t>& group,
                                                      const std::vector<PoseLink>& links) const;

 private:
  double ratio(const PoseLink& link) const;

  const std::vector<ViewSurface>& surfaces_;
  const VerificationThresholds& limits_;
  std::vector<std::optional<PoseLink>> best_;  // By view.
};

}  // namespace relief::registration
