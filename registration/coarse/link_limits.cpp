#include "registration/coarse/link_limits.h"

#include <algorithm>
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
// Of those links most are right, and right ones deviate by little more than these do.
constexpr double kShownQuantile = 0.75, kShownExcess = 1.25;
// How far limits may follow.
constexpr double kWidestRms = 2.5, kWidestCoherent = 5.0;
constexpr double kWidestContradiction = 0.1;  // Stray samples are fewer.

// The deviations of links, one list for each kind of evidence.
struct Deviations {
  std::vector<double> rms, normal_rms, coherent_rms, contradiction, absence;

  void add(const PoseLink& link, const std::vector<ViewSurface>& surfaces) {
    const ViewSurface &a = surfaces[link.a], &b = surfaces[link.b];
    rms.push_back(relative_rms(link.evidence, a, b));
    normal_rms.push_back(link.evidence.normal_rms);
    coherent_rms.push_back(link.evidence.coherent_rms / std::max(a.spacing(), b.spacing()));
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

double shown_by(std::vector<double> values, double fraction) {
  return kShownExcess * quantile(std::move(values), fraction);
}

// What links that close loops show of the errors, never beyond `widest`; zero where too few do.
PlausibleEvidence shown_errors(const std::vector<ViewSurface>& surfaces,
                               const std::vector<PoseLink>& links, const std::vector<int>& loops,
                               const PlausibleEvidence& widest) {
  Deviations found;
  for (std::size_t k = 0; k < links.size(); ++k)
    if (loops[k] > 0) found.add(links[k], surfaces);
  PlausibleEvidence shown = widest;
  const bool telling = found.rms.size() >= kTellingLinks;
  const auto take = [&](double& limit, std::vector<double> values, double fraction) {
    limit = telling ? std::min(limit, shown_by(std::move(values), fraction)) : 0.0;
  };
  take(shown.max_rms, std::move(found.rms), kShownQuantile);
  take(shown.max_normal_rms, std::move(found.normal_rms), kShownQuantile);
  take(shown.max_coherent_rms, std::move(found.coherent_rms), kShownQuantile);
  take(shown.max_contradiction, std::move(found.contradiction), kShownQuantile);
  // A laser and a camera lose what either does not see: how much depends on the pair.
  take(shown.max_absence, std::move(found.absence), 0.9);
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

PlausibleEvidence widest_limits(const PlausibleEvidence& general) {
  PlausibleEvidence widest = general;
  widest.max_rms *= kWidestRms;
  widest.max_coherent_rms *= kWidestCoherent;
  widest.max_contradiction = std::max(general.max_contradiction, kWidestContradiction);
  widest.max_absence = 1.0;
  return widest;
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
