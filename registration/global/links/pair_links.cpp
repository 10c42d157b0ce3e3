#include "registration/global/links/pair_links.h"

#include <algorithm>
#include <utility>

#include "registration/global/links/link_limits.h"
#include "registration/global/links/moved_piece.h"
#include "registration/global/links/off_plane_samples.h"
#include "registration/global/links/shared_constraint.h"
#include "scan/base/parallel.h"

namespace relief::registration {

PairLinks::PairLinks(const std::vector<ViewSurface>& surfaces,
                     const std::vector<ViewSurface>& whole, const ViewGroupOptions& options)
    : surfaces_(surfaces), whole_(whole), options_(options), symmetries_(surfaces.size()) {}

void PairLinks::find_faces() {
  faces_ = parallel_map<FlatFaces>(surfaces_.size(),
                                   [&](std::size_t i) { return find_flat_faces(surfaces_[i]); });
}

void PairLinks::set_symmetries(std::size_t view, std::vector<RigidMotion> motions) {
  symmetries_[view] = std::move(motions);
}

bool PairLinks::may_be_candidate(const PoseEvidence& evidence, const ViewSurface& a,
                                 const ViewSurface& b) const {
  return plausible(evidence, a, b, widest_limits()) ||
         may_be_right(evidence, a, b, options_.limits);
}

bool PairLinks::holds_whole_views(std::size_t a, std::size_t b, PoseHypothesis& hypothesis,
                                  const CoarseScale& scale) const {
  const auto whole = confirm_pose(whole_[a], whole_[b], hypothesis.b_from_a, scale, options_.judge);
  if (!whole || !may_be_candidate(whole->evidence, whole_[a], whole_[b])) return false;
  const PoseEvidence of_parts =
      judge_pose(surfaces_[a], surfaces_[b], whole->b_from_a, options_.judge);
  if (!may_be_candidate(of_parts, surfaces_[a], surfaces_[b])) return false;
  hypothesis = {whole->b_from_a, of_parts};
  return true;
}

bool PairLinks::keep_candidates(std::size_t a, std::size_t b,
                                std::vector<PoseHypothesis>& hypotheses,
                                const CoarseScale& scale) const {
  std::erase_if(hypotheses, [&](const PoseHypothesis& hypothesis) {
    return !may_be_candidate(hypothesis.evidence, surfaces_[a], surfaces_[b]);
  });
  const auto is_part = [&](std::size_t i) {
    return surfaces_[i].samples().size() < whole_[i].samples().size();
  };
  if (!is_part(a) && !is_part(b)) return false;
  VerificationThresholds firm = options_.limits;
  firm.min_overlap = options_.lone_overlap;
  bool denied = false;
  std::erase_if(hypotheses, [&](PoseHypothesis& hypothesis) {
    const PoseEvidence of_parts = hypothesis.evidence;
    if (holds_whole_views(a, b, hypothesis, scale)) return false;
    denied |= plausible(of_parts, surfaces_[a], surfaces_[b], firm) && !misses_coverage(of_parts);
    return true;
  });
  return denied;
}

VerificationThresholds PairLinks::widest_limits() const {
  VerificationThresholds limits = options_.limits;
  limits.max_coherent_rms = std::max(limits.max_coherent_rms, options_.confirmed_coherent_rms);
  return limits;
}

std::vector<PoseLink> PairLinks::of_pair(std::size_t a, std::size_t b,
                                         const std::vector<PoseHypothesis>& found,
                                         const CoarseScale& scale) const {
  const bool mostly_planar = is_mostly_planar(faces_[a]) || is_mostly_planar(faces_[b]);
  const bool planes_in_a = planes_dominate(faces_[a]), planes_in_b = planes_dominate(faces_[b]);
  const bool may_deny = mostly_planar || (planes_in_a && planes_in_b);
  std::vector<PoseLink> links;
  const auto add = [&](const PoseHypothesis& hypothesis) {
    const auto verdict =
        may_deny || planes_in_a || planes_in_b
            ? judge_off_plane_samples(surfaces_[a], faces_[a], surfaces_[b], faces_[b],
                                      hypothesis.b_from_a, options_.judge.min_stddev)
            : OffPlaneVerdict::kUnknown;
    if (may_deny && verdict == OffPlaneVerdict::kDenied) return;
    if (moved_before_still_sensor(surfaces_[a], surfaces_[b], hypothesis.b_from_a,
                                  options_.judge.min_stddev))
      return;
    links.push_back({a, b, hypothesis.b_from_a, hypothesis.evidence,
                     mostly_planar && verdict == OffPlaneVerdict::kUnknown,
                     verdict == OffPlaneVerdict::kConfirmed});
    links.back().lacks_shared_constraint =
        lacks_shared_constraint(surfaces_[a], surfaces_[b], hypothesis, scale, options_.judge);
  };
  for (const PoseHypothesis& hypothesis : found) add(hypothesis);
  if (!found.empty())
    for (const PoseHypothesis& other : alternatives(a, b, found.front().b_from_a, scale))
      add(other);
  // Off-plane samples meet at one pose of them.
  const auto planar_only = [](const PoseLink& link) { return link.planar_only; };
  if (!std::all_of(links.begin(), links.end(), planar_only)) std::erase_if(links, planar_only);
  return links;
}

std::vector<PoseHypothesis> PairLinks::alternatives(std::size_t a, std::size_t b,
                                                    const RigidMotion& b_from_a,
                                                    const CoarseScale& scale) const {
  const auto symmetries = [&](std::size_t i) {
    return symmetries_[i].value_or(std::vector<RigidMotion>{});
  };
  auto poses = alternative_poses(surfaces_[a], surfaces_[b], b_from_a, symmetries(a), symmetries(b),
                                 scale, options_.judge);
  keep_candidates(a, b, poses, scale);
  return poses;
}

}  // namespace relief::registration
