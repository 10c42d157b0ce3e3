#include "registration/coarse/view_groups.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "registration/coarse/pair_search.h"
#include "registration/robust.h"
#include "scan/parallel.h"

namespace relief {

namespace {

constexpr double kSamePlaceRadii = 0.15;  // Poses nearer than this are one, over a view's radius.
constexpr double kLoopRadii = 0.04, kLoopSpacings = 4.0;  // How well loops of three close.
constexpr double kTypicalQuantile = 0.25;                 // Of links; wrong ones are among them.
// Limits are not tightened below these: exact scans differ by what interpolation misses.
constexpr double kLeastRmsLimit = 0.6;  // Relative to noise and sampling.
constexpr double kLeastNormalLimit = 0.12;
constexpr double kLeastCoherentLimit = 0.12;  // [sample spacings]
constexpr double kCountingOverlap = 0.05;     // Pairs below say little.

using Motions = std::vector<RigidMotion>;

bool same_place(const ViewSurface& view, const RigidMotion& x, const RigidMotion& y) {
  return same_pose(view, x, y, kSamePlaceRadii * view.radius());
}

// Whether the two views could as well lie otherwise.
bool undetermined(const PoseLink& link) {
  return !link.given && (link.evidence.slides || link.ambiguous);
}

// How many views c confirm a link by two others: a - c - b leads to the same pose.
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

// Of the links between the same two views that which deviates least.
std::vector<const PoseLink*> best_of_each_pair(const std::vector<ViewSurface>& surfaces,
                                               const std::vector<PoseLink>& links) {
  std::map<std::pair<std::size_t, std::size_t>, std::pair<double, const PoseLink*>> best;
  for (const auto& link : links) {
    const std::pair found(relative_rms(link.evidence, surfaces[link.a], surfaces[link.b]), &link);
    const auto [it, added] = best.try_emplace(std::minmax(link.a, link.b), found);
    if (!added && found.first < it->second.first) it->second = found;
  }
  std::vector<const PoseLink*> links_of_pairs;
  for (const auto& [unused, found] : best) links_of_pairs.push_back(found.second);
  return links_of_pairs;
}

// The limits, tightened to what the better links of the project show. Noise that is alike over many
// pixels and errors of the calibration do not tell from the shape in a single view, but all pairs
// of a project have them: a pair that deviates much more than others is wrong.
PlausibleEvidence limits_of_project(const std::vector<ViewSurface>& surfaces,
                                    const std::vector<PoseLink>& links,
                                    const ViewGroupOptions& options) {
  std::vector<double> rms, normal_rms, coherent_rms;
  for (const PoseLink* link : best_of_each_pair(surfaces, links)) {
    const ViewSurface &a = surfaces[link->a], &b = surfaces[link->b];
    rms.push_back(relative_rms(link->evidence, a, b));
    normal_rms.push_back(link->evidence.normal_rms);
    coherent_rms.push_back(link->evidence.coherent_rms / std::max(a.spacing(), b.spacing()));
  }
  PlausibleEvidence limits = options.limits;
  const auto tighten = [&](double& limit, std::vector<double> values, double least) {
    if (values.empty()) return;
    const double typical = quantile(std::move(values), kTypicalQuantile);
    limit = std::min(limit, std::max(least, options.largest_excess * typical));
  };
  tighten(limits.max_rms, std::move(rms), kLeastRmsLimit);
  tighten(limits.max_normal_rms, std::move(normal_rms), kLeastNormalLimit);
  tighten(limits.max_coherent_rms, std::move(coherent_rms), kLeastCoherentLimit);
  return limits;
}

// Best supported first, without those that are not believed.
// `general`: the limits of any project.
void sort_by_support(const std::vector<ViewSurface>& surfaces, const ViewGroupOptions& options,
                     const PlausibleEvidence& general, std::vector<PoseLink>& links) {
  std::erase_if(links, [&](const PoseLink& link) {
    PlausibleEvidence limits = options.limits;
    limits.max_coherent_rms = options.confirmed_coherent_rms;
    return !link.given && !plausible(link.evidence, surfaces[link.a], surfaces[link.b], limits);
  });
  const auto loops = count_loops(surfaces, links);
  const auto firm = [&](const PoseLink& link) {
    return plausible(link.evidence, surfaces[link.a], surfaces[link.b], options.limits) &&
           !too_much_absent(link.evidence, options.limits);
  };
  const auto stands_alone = [&](const PoseLink& link) {
    return firm(link) && link.evidence.overlap >= options.lone_overlap &&
           !misfits_locally(link.evidence, surfaces[link.a], surfaces[link.b], general);
  };
  std::vector<std::size_t> order(links.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
    const auto key = [&](std::size_t k) {
      return std::tuple(links[k].given, !undetermined(links[k]), firm(links[k]), loops[k] > 0,
                        links[k].evidence.overlap);
    };
    return key(x) > key(y);
  });
  std::vector<PoseLink> sorted;
  for (const std::size_t k : order)
    if (links[k].given || loops[k] > 0 || stands_alone(links[k])) sorted.push_back(links[k]);
  links = std::move(sorted);
}

// One way of joining two groups.
struct Way {
  PoseLink link;
  RigidMotion first_from_second = RigidMotion::Identity();  // Frames of the groups.
  double support = 0.0;  // Sum of overlaps; 0 when any pair of views speaks against it.
};

class Joining {
 public:
  Joining(const std::vector<ViewSurface>& surfaces, const std::vector<PoseLink>& links,
          const std::vector<std::optional<RigidMotion>>& known, const ViewGroupOptions& options)
      : surfaces_(surfaces), links_(links), options_(options), known_(surfaces.size(), false) {
    groups_.group.resize(surfaces.size());
    std::iota(groups_.group.begin(), groups_.group.end(), std::size_t{0});
    groups_.group_from_view.assign(surfaces.size(), RigidMotion::Identity());
    std::size_t first = surfaces.size();
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      if (!known[i]) continue;
      first = std::min(first, i);
      groups_.group[i] = first;
      groups_.group_from_view[i] = *known[i];
      known_[i] = true;
    }
  }

  ViewGroups run() {
    while (join_next()) {
    }
    report_ambiguous();
    return std::move(groups_);
  }

 private:
  std::size_t group(std::size_t view) const { return groups_.group[view]; }

  // The groups that a link is between, the smaller first.
  std::pair<std::size_t, std::size_t> groups_of(const PoseLink& link) const {
    const std::size_t a = group(link.a), b = group(link.b);
    return {std::min(a, b), std::max(a, b)};
  }

  std::vector<std::size_t> members(std::size_t of) const {
    std::vector<std::size_t> list;
    for (std::size_t i = 0; i < groups_.group.size(); ++i)
      if (groups_.group[i] == of) list.push_back(i);
    return list;
  }

  // The best supported link that joins two groups does so.
  bool join_next() {
    for (const auto& link : links_) {
      if (group(link.a) == group(link.b)) continue;
      const auto key = groups_of(link);
      // What was decided about two groups holds until one of them grows.
      const auto sizes = std::pair(members(key.first).size(), members(key.second).size());
      if (const auto it = refused_.find(key); it != refused_.end() && it->second == sizes) continue;
      if (join(key.first, key.second)) return true;
      refused_[key] = sizes;
    }
    return false;
  }

  bool join(std::size_t first, std::size_t second) {
    const auto ways = possible_ways(first, second);
    if (ways.empty() || ambiguous(ways)) return false;
    const Way& best = ways.front();
    if (undetermined(best.link)) return false;
    // The group of known views keeps its frame, else the one of the first view.
    const bool move_first = holds_known(second) && !holds_known(first);
    const RigidMotion motion =
        move_first ? best.first_from_second.inverse() : best.first_from_second;
    for (const std::size_t i : members(move_first ? first : second))
      groups_.group_from_view[i] = motion * groups_.group_from_view[i];
    std::replace(groups_.group.begin(), groups_.group.end(), second, first);
    groups_.joined.push_back(best.link);
    return true;
  }

  bool holds_known(std::size_t of) const {
    for (std::size_t i = 0; i < known_.size(); ++i)
      if (known_[i] && groups_.group[i] == of) return true;
    return false;
  }

  // The different ways in which links join the two groups that no pair of views contradicts, the
  // best supported first; given poses before found ones.
  std::vector<Way> possible_ways(std::size_t first, std::size_t second) const {
    std::vector<Way> ways;
    for (const auto& link : links_) {
      const bool forward = group(link.a) == first && group(link.b) == second;
      const bool backward = group(link.a) == second && group(link.b) == first;
      if (!forward && !backward) continue;
      Way way{link, groups_.group_from_view[link.a] * link.b_from_a.inverse() *
                        groups_.group_from_view[link.b].inverse()};
      if (backward) way.first_from_second = way.first_from_second.inverse();
      const ViewSurface& moved = surfaces_[forward ? link.b : link.a];
      const RigidMotion& pose = groups_.group_from_view[forward ? link.b : link.a];
      const bool known = std::any_of(ways.begin(), ways.end(), [&](const Way& other) {
        return same_place(moved, way.first_from_second * pose, other.first_from_second * pose);
      });
      if (!known) ways.push_back(way);
    }
    for (Way& way : ways) way.support = support(first, second, way);
    std::erase_if(ways, [](const Way& way) { return way.support <= 0.0; });
    std::stable_sort(ways.begin(), ways.end(), [](const Way& x, const Way& y) {
      return std::tuple(x.link.given, x.support) > std::tuple(y.link.given, y.support);
    });
    return ways;
  }

  bool ambiguous(const std::vector<Way>& ways) const {
    return ways.size() > 1 && !ways[0].link.given &&
           ways[1].support >= options_.ambiguity * ways[0].support;
  }

  double support(std::size_t first, std::size_t second, const Way& way) const {
    const auto of_first = members(first), of_second = members(second);
    std::vector<double> parts(of_first.size() * of_second.size(), 0.0);
    parallel_for(parts.size(), 4, options_.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const std::size_t i = of_first[k / of_second.size()], j = of_second[k % of_second.size()];
        parts[k] = support_of_pair(i, j, way);
      }
    });
    return std::max(0.0, std::accumulate(parts.begin(), parts.end(), 0.0));
  }

  // Pairs of which too much is absent speak a little against a way that the user does not vouch
  // for.
  double support_of(const PoseEvidence& evidence, const Way& way) const {
    if (way.link.given || !too_much_absent(evidence, options_.limits)) return evidence.overlap;
    return -evidence.missing;
  }

  // What view j of the second group says for a way, seen from view i of the first: their overlap,
  // 0 where they hardly meet, or minus infinity when they deny it. Poses that follow from chains of
  // links are a little off: the pair may settle before it is judged, but not go elsewhere.
  double support_of_pair(std::size_t i, std::size_t j, const Way& way) const {
    PlausibleEvidence limits = options_.limits;
    limits.min_overlap = kCountingOverlap;
    limits.max_coherent_rms = options_.confirmed_coherent_rms;
    const ViewSurface &target = surfaces_[i], &source = surfaces_[j];
    const RigidMotion i_from_j =
        groups_.group_from_view[i].inverse() * way.first_from_second * groups_.group_from_view[j];
    PoseEvidence evidence = judge_pose(source, target, i_from_j, options_.judge);
    if (plausible(evidence, source, target, limits)) return support_of(evidence, way);
    const bool denies =
        contradicts(evidence, limits) || evidence.overlap >= options_.limits.min_overlap;
    if (!denies) return std::min(0.0, support_of(evidence, way));
    const double reach = kSamePlaceRadii * std::min(source.radius(), target.radius());
    const auto settled =
        refine_hypothesis(source, target, i_from_j, reach, options_.judge.association);
    if (same_place(source, settled.b_from_a, i_from_j) &&
        plausible(settled.evidence, source, target, limits))
      return support_of(settled.evidence, way);
    return -std::numeric_limits<double>::infinity();
  }

  void report_ambiguous() {
    std::set<std::pair<std::size_t, std::size_t>> told;
    for (const auto& link : links_) {
      const auto key = groups_of(link);
      if (key.first == key.second || !told.insert(key).second) continue;
      const auto ways = possible_ways(key.first, key.second);
      if (ways.empty()) continue;
      const PoseLink& best = ways.front().link;
      if (ambiguous(ways))
        groups_.ambiguous.push_back(
            {best.a, best.b, best.evidence.overlap, ways[1].link.evidence.overlap});
      else if (undetermined(best))
        groups_.ambiguous.push_back({best.a, best.b, best.evidence.overlap, best.evidence.overlap});
    }
  }

  const std::vector<ViewSurface>& surfaces_;
  const std::vector<PoseLink>& links_;
  const ViewGroupOptions& options_;
  std::vector<bool> known_;
  std::map<std::pair<std::size_t, std::size_t>, std::pair<std::size_t, std::size_t>> refused_;
  ViewGroups groups_;
};

}  // namespace

bool ViewGroups::all_in_one() const {
  return std::all_of(group.begin(), group.end(), [](std::size_t g) { return g == 0; });
}

ViewGroups join_views(const std::vector<ViewSurface>& surfaces, std::vector<PoseLink> links,
                      const std::vector<std::optional<RigidMotion>>& known,
                      const ViewGroupOptions& options) {
  assert(known.size() == surfaces.size());
  ViewGroupOptions adapted = options;
  adapted.limits = limits_of_project(surfaces, links, options);
  sort_by_support(surfaces, adapted, options.limits, links);
  return Joining(surfaces, links, known, adapted).run();
}

}  // namespace relief
