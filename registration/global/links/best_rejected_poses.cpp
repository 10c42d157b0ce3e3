#include "registration/global/links/best_rejected_poses.h"

namespace relief::registration {

double BestRejectedPoses::ratio(const PoseLink& link) const {
  return largest_ratio(link.evidence, surfaces_[link.a], surfaces_[link.b], limits_);
}

void BestRejectedPoses::add(std::size_t a, std::size_t b,
                            const std::vector<PoseHypothesis>& found) {
  best_.resize(surfaces_.size());
  for (const PoseHypothesis& hypothesis : found) {
    if (hypothesis.evidence.overlap < limits_.min_overlap) continue;
    const PoseLink link{a, b, hypothesis.b_from_a, hypothesis.evidence};
    for (const std::size_t i : {a, b})
      if (!best_[i] || ratio(link) < ratio(*best_[i])) best_[i] = link;
  }
}

std::vector<std::optional<PoseLink>> BestRejectedPoses::between_groups(
    const std::vector<std::size_t>& group, const std::vector<PoseLink>& links) const {
  std::vector<std::optional<PoseLink>> result(surfaces_.size());
  for (const PoseLink& link : links) {
    if (group[link.a] == group[link.b]) continue;
    for (const std::size_t i : {link.a, link.b})
      if (!result[i] || link.evidence.overlap > result[i]->evidence.overlap) result[i] = link;
  }
  for (std::size_t i = 0; i < best_.size(); ++i) {
    const auto& found = best_[i];
    if (found && !result[i] && group[found->a] != group[found->b]) result[i] = found;
  }
  return result;
}

}  // namespace relief::registration
