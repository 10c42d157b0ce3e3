#include "registration/posegraph/pairs/pair_matcher.h"

#include <algorithm>

#include "registration/pairwise/degenerate_directions.h"
#include "registration/pairwise/normal_maps/normal_matches.h"
#include "registration/posegraph/pairs/pair_fit.h"

namespace relief::registration {

namespace {

// Of all pairs at a time, before the last steps, which use all samples. Bounds the memory.
constexpr std::size_t kMostCorrespondences = 250'000;

ConstraintSpectrum stability_of(const Correspondences& found) {
  std::vector<OrientedPoint> points;
  points.reserve(found.items.size());
  for (const auto& c : found.items) points.push_back({c.target.point, c.target.normal});
  return analyse_constraints(points);
}

// The normal maps at the correspondences of a directed pair, without an opinion on motions that
// neither they nor geometry determine.
NormalMatches normals_of(const std::vector<ViewSurface>& surfaces, const DirectedMatches& directed,
                         const RigidMotion& target_from_source, int signal_level) {
  const ViewSurface &source = surfaces[directed.source], &target = surfaces[directed.target];
  auto normals = match_normals(source, target, target_from_source, directed.found, signal_level);
  if (normals.items.empty()) return normals;
  const double threshold = degeneracy_threshold(source, target);
  const ConstraintSpectrum spectrum =
      with_normal_maps(stability_of(directed.found), normals,
                       directed.found.sigma / normals.effective_sigma, threshold);
  for (const auto& free : degenerate_directions(spectrum, threshold))
    ignore_motion(free.motion, free.centre, normals);
  return normals;
}

}  // namespace

CorrespondenceOptions search_at(const SearchLevel& level, std::size_t pairs, int fewest,
                                const JointRefinementOptions& options) {
  const std::size_t share = kMostCorrespondences / std::max<std::size_t>(1, 2 * pairs);
  CorrespondenceOptions search;
  search.count = std::min(level.count, std::max(static_cast<int>(share), fewest));
  search.max_distance = level.max_distance;
  search.max_normal_angle_deg = options.max_normal_angle_deg;
  search.association = options.association;
  return search;
}

DirectedMatches PairMatcher::operator()(std::size_t i) const {
  DirectedMatches directed;
  directed.source = source_of(pairs_, i);
  directed.target = target_of(pairs_, i);
  const RigidMotion target_from_source =
      world_from_view_[directed.target].inverse() * world_from_view_[directed.source];
  directed.found = find_correspondences(surfaces_[directed.source], surfaces_[directed.target],
                                        target_from_source, search_);
  if (by_normal_maps(i))
    directed.normals = normals_of(surfaces_, directed, target_from_source, signal_level_);
  return directed;
}

}  // namespace relief::registration
