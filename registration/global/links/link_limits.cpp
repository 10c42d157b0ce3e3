#include "registration/global/links/link_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "registration/global/links/pair_support.h"
#include "registration/global/pair_search.h"
#include "registration/pairwise/robust.h"
#include "registration/pairwise/search_schedule.h"
#include "registration/verification/common_errors.h"

namespace relief::registration {

namespace {

// With the limits of this file `relief_coarse_runs` places no view of 200 difficult scenes wrongly
// (docs/results.md, Global registration).

// How well loops of three close [radii of a view], a turn of 4.6 degrees or a shift, and [sample
// spacings], as far as the finest level of ICP searches in exact views.
constexpr double kLoopRadii = 0.04, kLoopSpacings = 4.0;
constexpr double kTypicalQuantile = 0.25;  // Of links: right while a quarter of them are.
// Limits are not tightened below these: exact scans differ by what interpolation misses.
// Relative to largest_plausible_rms(): 0.09 spacings. White noise gives 0.67, 1 / 1.5.
constexpr double kLeastRmsLimit = 0.6;
// Length of a difference of unit normals: 7 degrees. Two that are good to 2 differ by 2.8.
constexpr double kLeastNormalLimit = 0.12;
// The same of candidates, 11 degrees: neighbours that share noise turn normals by more than white
// noise would. A Kinect's differ by 0.21 to 0.28 at right poses; at wrong ones, where they are
// within 40 degrees to be compared at all, by 0.35 to 0.39.
constexpr double kCandidateNormalLimit = 0.2;
constexpr double kLeastCoherentLimit = 0.12;  // [coherence_scale()]; general is 0.2.
// A triangle may close by chance; more links that close loops tell the errors of the views.
constexpr std::size_t kTellingLinks = 4;
// Wrong poses misfit in proportion to the size of the views: by a spacing and more on an object of
// a hundred spacings, which is 2 % of its radius. Errors of a quarter of that are told from them.
constexpr double kTolerableRadii = 0.005;
// Pairs at poses of chains, and links that loops confirm, may deviate by so many times what the
// better quarter of the pairs of views does: more than links that stand alone, with 1.5.
constexpr double kConfirmedExcess = 1.75;
// Absence and strays depend on the pair: most links believed otherwise show no more.
constexpr double kAbsenceQuantile = 0.9, kStraysQuantile = 0.75, kStraysExcess = 1.6;
constexpr double kLoopsRmsQuantile = 0.9;
// How far limits may follow [general limits]: to 0.8 spacings of RMS in exact views, one of
// coherent residual and a twentieth in front. Wrong poses settle at a spacing and rarely show less
// in front.
constexpr double kWidestRms = 2.5, kWidestCoherent = 5.0, kWidestContradiction = 2.5;
// Standard deviations of the normals' noise by which those of right poses may differ: 0.3 % of a
// Gaussian lies beyond.
constexpr double kNormalDeviations = 3.0;

// The deviations of links, one list for each kind of evidence.
struct Deviations {
  std::vector<double> rms, normal_rms, coherent_rms;

  void add(const PoseLink& link, const std::vector<ViewSurface>& surfaces) {
    const ViewSurface &a = surfaces[link.a], &b = surfaces[link.b];
    rms.push_back(relative_rms(link.evidence, a, b));
    normal_rms.push_back(link.evidence.normal_rms);
    coherent_rms.push_back(link.evidence.coherent_rms / coherence_scale(a, b));
  }
};

// Of the links between the same two views that which deviates least. Those that leave the pose open
// in some direction fit by that, and tell nothing of errors where there are others.
std::vector<const PoseLink*> best_of_each_pair(const std::vector<ViewSurface>& surfaces,
                                               const std::vector<const PoseLink*>& links) {
  using Order = std::pair<bool, double>;
  std::map<std::pair<std::size_t, std::size_t>, std::pair<Order, const PoseLink*>> best;
  for (const PoseLink* link : links) {
    const Order order{link->degenerate(),
                      relative_rms(link->evidence, surfaces[link->a], surfaces[link->b])};
    const std::pair found(order, link);
    const auto [it, added] = best.try_emplace(std::minmax(link->a, link->b), found);
    if (!added && order < it->second.first) it->second = found;
  }
  std::vector<const PoseLink*> links_of_pairs;
  for (const auto& [unused, found] : best) links_of_pairs.push_back(found.second);
  return links_of_pairs;
}

// The limits that follow from what the better quarter of the pairs of views deviates by, `excess`
// times; `general` ones are only tightened.
VerificationThresholds follow(const std::vector<ViewSurface>& surfaces,
                              const std::vector<const PoseLink*>& links, double excess,
                              VerificationThresholds limits) {
  Deviations found;
  for (const PoseLink* link : best_of_each_pair(surfaces, links)) found.add(*link, surfaces);
  const auto tighten = [&](double& limit, std::vector<double> values, double least) {
    if (values.empty()) return;
    const double typical = quantile(std::move(values), kTypicalQuantile);
    limit = std::min(limit, std::max(least, excess * typical));
  };
  tighten(limits.max_rms, std::move(found.rms), kLeastRmsLimit);
  tighten(limits.max_normal_rms, std::move(found.normal_rms), kLeastNormalLimit);
  tighten(limits.max_coherent_rms, std::move(found.coherent_rms), kLeastCoherentLimit);
  return limits;
}

std::vector<const PoseLink*> those_within(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<const PoseLink*>& links,
                                          const VerificationThresholds& limits) {
  std::vector<const PoseLink*> within;
  for (const PoseLink* link : links)
    if (plausible(link->evidence, surfaces[link->a], surfaces[link->b], limits))
      within.push_back(link);
  return within;
}

// Whether two views are of one place: samples of the one lie on those of the other. Both have the
// same errors of the sensor, and fit wherever the other one does.
bool is_repeated(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a) {
  return same_pose(a, b_from_a, RigidMotion::Identity(), coarser_spacing(a, b));
}

bool is_repeated(const std::vector<ViewSurface>& surfaces, const PoseLink& link) {
  return is_repeated(surfaces[link.a], surfaces[link.b], link.b_from_a);
}

// The links that tell what errors the views have: those that share enough to be believed alone, or
// close loops. Small patches fit better, also at wrong poses, and so do repeated views: where there
// are others, they tell nothing.
std::vector<const PoseLink*> telling_links(const std::vector<ViewSurface>& surfaces,
                                           const std::vector<PoseLink>& links,
                                           const std::vector<int>& loops, double lone_overlap) {
  std::vector<const PoseLink*> telling, apart, all;
  for (std::size_t k = 0; k < links.size(); ++k) {
    all.push_back(&links[k]);
    if (is_repeated(surfaces, links[k])) continue;
    apart.push_back(&links[k]);
    if (loops[k] > 0 || links[k].evidence.overlap >= lone_overlap) telling.push_back(&links[k]);
  }
  if (!telling.empty()) return telling;
  return apart.empty() ? all : apart;
}

using ViewIndices = std::pair<std::size_t, std::size_t>;

// Pairs of views whose links close loops at two places: views of a body of revolution, or of what
// repeats itself, do so wherever they are turned to, and their loops tell nothing.
std::set<ViewIndices> ambiguous_pairs(const std::vector<ViewSurface>& surfaces,
                                      const std::vector<PoseLink>& links,
                                      const std::vector<int>& loops) {
  std::map<ViewIndices, RigidMotion> first;  // Of the view with the larger index from the other.
  std::set<ViewIndices> found;
  for (std::size_t k = 0; k < links.size(); ++k) {
    if (loops[k] == 0) continue;
    const PoseLink& link = links[k];
    const ViewIndices pair = std::minmax(link.a, link.b);
    const RigidMotion pose = link.a < link.b ? link.b_from_a : link.b_from_a.inverse();
    const auto [it, added] = first.try_emplace(pair, pose);
    if (!added && !same_place(surfaces[pair.first], pose, it->second)) found.insert(pair);
  }
  return found;
}

// What links that close loops and are believed otherwise show of strays and of missing samples.
// False where too few do.
bool follow_losses(const std::vector<ViewSurface>& surfaces, const std::vector<PoseLink>& links,
                   const std::vector<int>& loops, VerificationThresholds& limits) {
  VerificationThresholds otherwise = limits;
  otherwise.max_free_space_violation =
      std::min(1.0, kWidestContradiction * otherwise.max_free_space_violation);
  std::vector<double> missing_coverage, free_space_violation;
  const std::set<ViewIndices> ambiguous = ambiguous_pairs(surfaces, links, loops);
  std::set<ViewIndices> telling;
  for (std::size_t k = 0; k < links.size(); ++k) {
    const PoseLink& link = links[k];
    if (loops[k] == 0 || is_repeated(surfaces, link) ||
        ambiguous.contains(std::minmax(link.a, link.b)) ||
        !plausible(link.evidence, surfaces[link.a], surfaces[link.b], otherwise))
      continue;
    telling.insert(std::minmax(link.a, link.b));
    missing_coverage.push_back(link.evidence.missing_coverage);
    free_space_violation.push_back(link.evidence.free_space_violation);
  }
  if (telling.size() < kTellingLinks) return false;
  limits.max_missing_coverage = std::max(limits.max_missing_coverage,
                                         quantile(std::move(missing_coverage), kAbsenceQuantile));
  limits.max_free_space_violation =
      std::clamp(kStraysExcess * quantile(std::move(free_space_violation), kStraysQuantile),
                 limits.max_free_space_violation, otherwise.max_free_space_violation);
  return true;
}

// What pairs of views deviate by whose links several loops close, and that are believed otherwise.
// Noise and its estimate depend on the pair too, and loops do not agree by chance. 0 for too few.
double rms_of_loops(const std::vector<ViewSurface>& surfaces, const std::vector<PoseLink>& links,
                    const std::vector<int>& loops, VerificationThresholds limits) {
  limits.max_rms = std::numeric_limits<double>::infinity();
  const std::set<ViewIndices> ambiguous = ambiguous_pairs(surfaces, links, loops);
  std::vector<const PoseLink*> closed;
  for (std::size_t k = 0; k < links.size(); ++k)
    if (loops[k] >= kTellingLoops && !is_repeated(surfaces, links[k]) &&
        !ambiguous.contains(std::minmax(links[k].a, links[k].b)) &&
        plausible(links[k].evidence, surfaces[links[k].a], surfaces[links[k].b], limits))
      closed.push_back(&links[k]);
  Deviations found;
  for (const PoseLink* link : best_of_each_pair(surfaces, closed)) found.add(*link, surfaces);
  return found.rms.size() < kTellingLinks ? 0.0 : quantile(std::move(found.rms), kLoopsRmsQuantile);
}

// The median of the links' coherence_scale() [unit]; infinite without links.
double typical_coherence_scale(const std::vector<ViewSurface>& surfaces,
                               const std::vector<const PoseLink*>& links) {
  std::vector<double> scales;
  for (const PoseLink* link : links)
    scales.push_back(coherence_scale(surfaces[link->a], surfaces[link->b]));
  return scales.empty() ? std::numeric_limits<double>::infinity()
                        : quantile(std::move(scales), 0.5);
}

LinkLimits with_loop_confirmed(LinkLimits limits, const VerificationThresholds& general) {
  limits.loop_confirmed = limits.confirmed;
  limits.loop_confirmed.max_free_space_violation =
      std::max(limits.confirmed.max_free_space_violation,
               std::min(1.0, kWidestContradiction * general.max_free_space_violation));
  return limits;
}

}  // namespace

std::vector<int> count_loops(const std::vector<ViewSurface>& surfaces,
                             const std::vector<PoseLink>& links) {
  std::vector<std::vector<std::pair<std::size_t, RigidMotion>>> from(surfaces.size());
  for (const auto& link : links) {
    from[link.a].emplace_back(link.b, link.b_from_a);
    from[link.b].emplace_back(link.a, link.b_from_a.inverse());
  }
  const auto agree = [&](const PoseLink& link, const RigidMotion& other) {
    const ViewSurface& view = surfaces[link.a];
    return same_pose(view, link.b_from_a, other,
                     std::max(kLoopRadii * view.radius(), kLoopSpacings * view.spacing()));
  };
  const auto is_near_identity = [&](std::size_t view, const RigidMotion& motion) {
    return same_pose(surfaces[view], motion, RigidMotion::Identity(),
                     kFirstSearchRadii * surfaces[view].radius());
  };
  std::vector<int> loops(links.size(), 0);
  for (std::size_t k = 0; k < links.size(); ++k) {
    const auto& link = links[k];
    std::set<std::size_t> confirming;
    const bool near_identity = is_near_identity(link.a, link.b_from_a);
    for (const auto& [c, c_from_a] : from[link.a]) {
      if (is_repeated(surfaces[link.a], surfaces[c], c_from_a)) continue;
      const bool both = near_identity && is_near_identity(link.a, c_from_a);
      for (const auto& [end, end_from_c] : from[c]) {
        if (end != link.b || is_repeated(surfaces[c], surfaces[end], end_from_c) ||
            (both && is_near_identity(c, end_from_c)))
          continue;
        if (agree(link, end_from_c * c_from_a)) confirming.insert(c);
      }
    }
    loops[k] = static_cast<int>(confirming.size());
  }
  return loops;
}

bool may_be_right(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
                  const VerificationThresholds& general) {
  VerificationThresholds limits = general;
  limits.max_rms *= kWidestRms;
  limits.max_free_space_violation =
      std::min(1.0, kWidestContradiction * general.max_free_space_violation);
  limits.max_normal_rms = std::min(
      general.max_normal_rms,
      kCandidateNormalLimit + kNormalDeviations * std::hypot(a.normal_error(), b.normal_error()));
  limits.max_coherent_rms = std::max(kWidestCoherent * general.max_coherent_rms,
                                     kWarpDeviations * joint_noise(a, b) / coherence_scale(a, b));
  return plausible(evidence, a, b, limits);
}

VerificationThresholds widened_coherent_limit(VerificationThresholds limits,
                                              const VerificationThresholds& general) {
  limits.max_coherent_rms =
      std::max(limits.max_coherent_rms, kWidestCoherent * general.max_coherent_rms);
  return limits;
}

double stddev_of_loops(const std::vector<ViewSurface>& surfaces,
                       const std::vector<PoseLink>& links) {
  const std::vector<int> loops = count_loops(surfaces, links);
  std::vector<PairDeviation> pairs;
  for (std::size_t k = 0; k < links.size(); ++k) {
    const PoseLink& link = links[k];
    const bool known = !pairs.empty() && pairs.back().a == link.a && pairs.back().b == link.b;
    if (loops[k] > 0 && !known && !is_repeated(surfaces, link))
      pairs.push_back({link.a, link.b, link.evidence.rms});
  }
  if (pairs.size() < kTellingLinks) return 0.0;
  std::vector<double> radii;
  for (const ViewSurface& surface : surfaces)
    if (!surface.samples().empty()) radii.push_back(surface.radius());
  const double stddev = common_stddev(surfaces, pairs);
  return stddev <= kTolerableRadii * quantile(std::move(radii), 0.5) ? stddev : 0.0;
}

LinkLimits fit_link_limits(const std::vector<ViewSurface>& surfaces,
                           const std::vector<PoseLink>& links, const std::vector<int>& loops,
                           const ViewGroupOptions& options) {
  // Beyond the general limits where even the better pairs are, and loops close all the same.
  const auto telling = telling_links(surfaces, links, loops, options.lone_overlap);
  VerificationThresholds open = options.limits;
  open.max_rms *= kWidestRms;
  open.max_coherent_rms = std::numeric_limits<double>::infinity();  // See may_be_right().
  LinkLimits wide{follow(surfaces, telling, options.largest_excess, open),
                  follow(surfaces, telling, kConfirmedExcess, open),
                  {}};
  // Errors beyond the noise are smooth: neighbours share them.
  const double shared = options.judge.min_stddev / typical_coherence_scale(surfaces, telling);
  wide.lone.max_coherent_rms =
      std::max(wide.lone.max_coherent_rms, options.largest_excess * shared);
  wide.confirmed.max_coherent_rms = std::max(
      {wide.confirmed.max_coherent_rms, options.confirmed_coherent_rms, kConfirmedExcess * shared});
  if (follow_losses(surfaces, links, loops, wide.confirmed)) {
    wide.lone.max_missing_coverage = wide.confirmed.max_missing_coverage;
    wide.lone.max_free_space_violation = wide.confirmed.max_free_space_violation;
    LinkLimits limits = with_loop_confirmed(wide, options.limits);
    limits.loop_confirmed.max_rms =
        std::clamp(rms_of_loops(surfaces, links, loops, limits.loop_confirmed),
                   limits.confirmed.max_rms, open.max_rms);
    return limits;
  }
  VerificationThresholds believed = options.limits;
  believed.max_coherent_rms = std::max(believed.max_coherent_rms, options.confirmed_coherent_rms);
  const auto links_believed = those_within(surfaces, telling, believed);
  LinkLimits limits{
      follow(surfaces, links_believed, options.largest_excess, options.limits), {}, {}};
  limits.confirmed = limits.lone;
  limits.confirmed.max_coherent_rms = believed.max_coherent_rms;
  return with_loop_confirmed(limits, options.limits);
}

}  // namespace relief::registration
