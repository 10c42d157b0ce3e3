#include "registration/global/links/pair_support.h"

#include <algorithm>
#include <limits>

#include "registration/global/pair_search.h"

namespace relief::registration {

namespace {

// Poses nearer than this are one [radii of a view], turns of less than 17 degrees: three links that
// each err by what loops may (0.04) differ by less, a cube's next pose by 90 degrees.
constexpr double kSamePlaceRadii = 0.15;

// How much a pair beyond its limits speaks against a pose, in the unit of overlaps: one at twice
// its limit as much as one within it speaks for the pose. Of many pairs at right poses some are a
// little beyond; wrong poses are far beyond in most, and in space seen empty by tens of times.
double penalty(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
               const VerificationThresholds& limits) {
  const double ratio = largest_ratio(evidence, a, b, limits);
  return (evidence.overlap + evidence.in_front) * std::max(0.0, ratio - 1.0);
}

}  // namespace

bool same_place(const ViewSurface& view, const RigidMotion& x, const RigidMotion& y) {
  return same_pose(view, x, y, kSamePlaceRadii * view.radius());
}

double PairSupport::support(std::size_t i, std::size_t j, const RigidMotion& i_from_j) const {
  const ViewSurface &target = surfaces_[i], &source = surfaces_[j];
  const PoseLink* const link = link_at(i, j, i_from_j);
  const bool linked = link != nullptr;
  VerificationThresholds limits = linked ? limits_.loop_confirmed : limits_.confirmed;
  if (linked && link->off_plane_confirmed) limits = widened_coherent_limit(limits, options_.limits);
  limits.min_overlap = kCountingOverlap;
  const PoseEvidence evidence = judged_.judge(i, j, i_from_j, options_.judge);
  if (plausible(evidence, source, target, limits)) return support_of(evidence, linked);
  const bool denies =
      violates_free_space(evidence, limits) || evidence.overlap >= options_.limits.min_overlap;
  if (!denies) return std::min(0.0, support_of(evidence, linked));
  const double reach = kSamePlaceRadii * std::min(source.radius(), target.radius());
  auto settled = judged_.settle(i, j, i_from_j, reach, options_.judge);
  if (settled.evidence.overlap <= 0.0) settled.evidence = evidence;  // Nothing was fitted.
  if (!same_place(source, settled.b_from_a, i_from_j))
    return -std::numeric_limits<double>::infinity();
  if (plausible(settled.evidence, source, target, limits))
    return support_of(settled.evidence, linked);
  // Where two views settle alone may be worse than where the others have them.
  return -std::min(penalty(settled.evidence, source, target, limits),
                   penalty(evidence, source, target, limits));
}

// Missing coverage counts against a pose, unless the search of this pair found the same pose: a
// search and a chain of other links hardly ever agree by chance, and clouds are often cut.
double PairSupport::support_of(const PoseEvidence& evidence, bool linked) const {
  if (linked || !misses_coverage(evidence, limits_.confirmed)) return evidence.overlap;
  return -evidence.missing;
}

// A link that is believed and says the same, one that off-plane samples confirm first; or null.
const PoseLink* PairSupport::link_at(std::size_t i, std::size_t j,
                                     const RigidMotion& i_from_j) const {
  const PoseLink* found = nullptr;
  const auto look_at = [&](const PoseLink* link, const RigidMotion& motion) {
    if (found && (found->off_plane_confirmed || !link->off_plane_confirmed)) return;
    if (same_place(surfaces_[j], motion, i_from_j)) found = link;
  };
  for (const PoseLink* link : index_.between(j, i)) look_at(link, link->b_from_a);
  for (const PoseLink* link : index_.between(i, j)) look_at(link, link->b_from_a.inverse());
  return found;
}

}  // namespace relief::registration
