#include "registration/coarse/view_groups.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "registration/coarse/pair_search.h"
#include "scan/parallel.h"

namespace relief {

namespace {

constexpr double kSamePlaceRadii = 0.15;  // Poses nearer than this are one, over a view's radius.
constexpr double kLoopRadii = 0.04, kLoopSpacings = 4.0;  // How well loops of three close.
constexpr double kCountingOverlap = 0.05;                 // Pairs below say little.
constexpr double kJoinedMisfit = 2.5;  // Allowance for poses that are joined but not refined.

using Motions = std::vector<RigidMotion>;

bool same_place(const ViewSurface& view, const RigidMotion& x, const RigidMotion& y) {
  return same_pose(view, x, y, kSamePlaceRadii * view.radius());
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

// Best supported first, without those that are not believed.
void sort_by_support(const std::vector<ViewSurface>& surfaces, const ViewGroupOptions& options,
                     std::vector<PoseLink>& links) {
  const auto loops = count_loops(surfaces, links);
  const auto firm = [&](const PoseLink& link) {
    return plausible(link.evidence, surfaces[link.a], surfaces[link.b], options.limits);
  };
  std::vector<std::size_t> order(links.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
    const auto key = [&](std::size_t k) {
      return std::tuple(links[k].given, !links[k].evidence.slides, firm(links[k]), loops[k] > 0,
                        links[k].evidence.overlap);
    };
    return key(x) > key(y);
  });
  std::vector<PoseLink> sorted;
  for (const std::size_t k : order)
    if (links[k].given || loops[k] > 0 ||
        (firm(links[k]) && links[k].evidence.overlap >= options.lone_overlap))
      sorted.push_back(links[k]);
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
    if (best.link.evidence.slides && !best.link.given) return false;
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
    for (Way& way : ways) way.support = support(first, second, way.first_from_second);
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

  double support(std::size_t first, std::size_t second,
                 const RigidMotion& first_from_second) const {
    const auto of_first = members(first), of_second = members(second);
    std::vector<double> parts(of_first.size() * of_second.size(), 0.0);
    PlausibleEvidence limits = options_.limits;
    limits.min_overlap = kCountingOverlap;
    limits.max_rms *= kJoinedMisfit;
    limits.max_coherent_rms *= kJoinedMisfit;
    parallel_for(parts.size(), 4, options_.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const std::size_t i = of_first[k / of_second.size()], j = of_second[k % of_second.size()];
        const RigidMotion i_from_j =
            groups_.group_from_view[i].inverse() * first_from_second * groups_.group_from_view[j];
        const auto evidence = judge_pose(surfaces_[j], surfaces_[i], i_from_j, options_.judge);
        if (plausible(evidence, surfaces_[j], surfaces_[i], limits))
          parts[k] = evidence.overlap;
        else if (contradicts(evidence, limits) || evidence.overlap >= options_.limits.min_overlap)
          parts[k] = -std::numeric_limits<double>::infinity();
      }
    });
    return std::max(0.0, std::accumulate(parts.begin(), parts.end(), 0.0));
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
      else if (best.evidence.slides)
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
  sort_by_support(surfaces, options, links);
  return Joining(surfaces, links, known, options).run();
}

}  // namespace relief
