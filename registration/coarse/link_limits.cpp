#include "registration/coarse/link_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "registration/coarse/pair_search.h"
#include "registration/robust.h"

namespace relief {

namespace {

constexpr double kLoopRadii = 0.04, kLoopSpacings = 4.0;  // How well loops of three close.
constexpr double kTypicalQuantile = 0.25;                 // Of links; wrong ones are among them.
// Limits are not tightened below these: exact scans differ by what interpolation misses.
constexpr double kLeastRmsLimit = 0.6;  // Relative to noise and sampling.
constexpr double kLeastNormalLimit = 0.12;
constexpr double kLeastCoherentLimit = 0.12;  // [sample spacings]
// A triangle may close by chance; more links that close loops tell the errors of the views.
constexpr std::size_t kTellingLinks = 4;
// Right links deviate by no more than so many times the median of them.
constexpr double kShownExcess = 1.6;
// Absence depends on the pair: of links believed otherwise, nearly all show no more.
constexpr double kAbsenceQuantile = 0.9;
// So does the part of stray samples; wrong links show far more.
constexpr double kStraysQuantile = 0.75;
// A calibration is made to the noise of its sensor: its errors are hardly more than twice that.
constexpr double kWarpDeviations = 2.0;
// How far limits may follow.
constexpr double kWidestRms = 2.5, kWidestCoherent = 5.0, kWidestContradiction = 2.5;
// Standard deviations of the normals' noise by which those of right poses may differ.
constexpr double kNormalDeviations = 3.0;

// The deviations of links, one list for each kind of evidence.
struct Deviations {
  std::vector<double> rms, normal_rms, coherent_rms, contradiction, absence;

  void add(const PoseLink& link, const std::vector<ViewSurface>& surfaces) {
    const ViewSurface &a = surfaces[link.a], &b = surfaces[link.b];
    rms.push_back(relative_rms(link.evidence, a, b));
    normal_rms.push_back(link.evidence.normal_rms);
    coherent_rms.push_back(relative_coherent_rms(link.evidence, a, b));
    contradiction.push_back(link.evidence.contradiction);
    absence.push_back(link.evidence.absence);
  }
};

// Of the links between the same two views that which deviates least.
std::vector<const PoseLink*> best_of_each_pair(const std::vector<ViewSurface>& surfaces,
                                               const std::vector<const PoseLink*>& links) {
  std::map<std::pair<std::size_t, std::size_t>, std::pair<double, const PoseLink*>> best;
  for (const PoseLink* link : links) {
    const std::pair found(relative_rms(link->evidence, surfaces[link->a], surfaces[link->b]), link);
    const auto [it, added] = best.try_emplace(std::minmax(link->a, link->b), found);
    if (!added && found.first < it->second.first) it->second = found;
  }
  std::vector<const PoseLink*> links_of_pairs;
  for (const auto& [unused, found] : best) links_of_pairs.push_back(found.second);
  return links_of_pairs;
}

PlausibleEvidence widest_limits(const PlausibleEvidence& general) {
  PlausibleEvidence widest = general;
  widest.max_rms *= kWidestRms;
  widest.max_coherent_rms *= kWidestCoherent;
  widest.max_contradiction = std::min(1.0, kWidestContradiction * general.max_contradiction);
  widest.max_absence = 1.0;
  return widest;
}

// What links that close loops show of the errors, never beyond `widest`; zero where too few do.
PlausibleEvidence shown_errors(const std::vector<ViewSurface>& surfaces,
                               const std::vector<PoseLink>& links, const std::vector<int>& loops,
                               const PlausibleEvidence& widest) {
  Deviations found;
  for (std::size_t k = 0; k < links.size(); ++k)
    if (loops[k] > 0) found.add(links[k], surfaces);
  PlausibleEvidence shown = widest;
  shown.max_coherent_rms = std::numeric_limits<double>::infinity();  // See may_be_right().
  if (found.rms.size() < kTellingLinks) return {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  const auto take = [](double& limit, std::vector<double> values) {
    limit = std::min(limit, kShownExcess * quantile(std::move(values), 0.5));
  };
  take(shown.max_rms, std::move(found.rms));
  take(shown.max_normal_rms, std::move(found.normal_rms));
  take(shown.max_coherent_rms, std::move(found.coherent_rms));
  shown.max_contradiction =
      std::min(shown.max_contradiction,
               kShownExcess * quantile(std::move(found.contradiction), kStraysQuantile));
  // A laser and a camera lose what either does not see.
  std::vector<double> absence;
  for (std::size_t k = 0; k < links.size(); ++k)
    if (loops[k] > 0 &&
        plausible(links[k].evidence, surfaces[links[k].a], surfaces[links[k].b], shown))
      absence.push_back(links[k].evidence.absence);
  shown.max_absence = quantile(std::move(absence), kAbsenceQuantile);
  return shown;
}

void widen(PlausibleEvidence& limits, const PlausibleEvidence& shown) {
  limits.max_rms = std::max(limits.max_rms, shown.max_rms);
  limits.max_normal_rms = std::max(limits.max_normal_rms, shown.max_normal_rms);
  limits.max_coherent_rms = std::max(limits.max_coherent_rms, shown.max_coherent_rms);
  limits.max_contradiction = std::max(limits.max_contradiction, shown.max_contradiction);
  limits.max_absence = std::max(limits.max_absence, shown.max_absence);
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
  std::vector<int> loops(links.size(), 0);
  for (std::size_t k = 0; k < links.size(); ++k) {
    const auto& link = links[k];
    std::set<std::size_t> confirming;
    for (const auto& [c, c_from_a] : from[link.a])
      for (const auto& [end, end_from_c] : from[c])
        if (end == link.b && agree(link, end_from_c * c_from_a)) confirming.insert(c);
    loops[k] = static_cast<int>(confirming.size());
  }
  return loops;
}

bool may_be_right(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
                  const PlausibleEvidence& general) {
  PlausibleEvidence limits = widest_limits(general);
  limits.max_normal_rms = std::min(
      general.max_normal_rms,
      kLeastNormalLimit + kNormalDeviations * std::hypot(a.normal_error(), b.normal_error()));
  limits.max_coherent_rms =
      std::max(limits.max_coherent_rms, kWarpDeviations * std::hypot(a.noise(), b.noise()) /
                                            std::max(a.spacing(), b.spacing()));
  return plausible(evidence, a, b, limits);
}

LinkLimits fit_link_limits(const std::vector<ViewSurface>& surfaces,
                           const std::vector<PoseLink>& links, const std::vector<int>& loops,
                           const ViewGroupOptions& options) {
  const PlausibleEvidence shown =
      shown_errors(surfaces, links, loops, widest_limits(options.limits));
  LinkLimits limits{options.limits, options.limits};
  limits.confirmed.max_coherent_rms =
      std::max(options.limits.max_coherent_rms, options.confirmed_coherent_rms);
  widen(limits.confirmed, shown);

  std::vector<const PoseLink*> believable;
  for (const PoseLink& link : links)
    if (plausible(link.evidence, surfaces[link.a], surfaces[link.b], limits.confirmed))
      believable.push_back(&link);
  Deviations found;
  for (const PoseLink* link : best_of_each_pair(surfaces, believable)) found.add(*link, surfaces);
  const auto tighten = [&](double& limit, std::vector<double> values, double least) {
    if (values.empty()) return;
    const double typical = quantile(std::move(values), kTypicalQuantile);
    limit = std::min(limit, std::max(least, options.largest_excess * typical));
  };
  tighten(limits.lone.max_rms, std::move(found.rms), kLeastRmsLimit);
  tighten(limits.lone.max_normal_rms, std::move(found.normal_rms), kLeastNormalLimit);
  tighten(limits.lone.max_coherent_rms, std::move(found.coherent_rms), kLeastCoherentLimit);
  widen(limits.lone, shown);
  limits.confirmed.max_rms = limits.lone.max_rms;
  limits.confirmed.max_normal_rms = limits.lone.max_normal_rms;
  return limits;
}

}  // namespace relief
