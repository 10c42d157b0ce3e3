#include "registration/global/view_groups.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "registration/global/judged_pairs.h"
#include "registration/global/links/link_limits.h"
#include "registration/global/links/pair_support.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

constexpr std::size_t kPairsAtOnce = 16;  // Judged side by side.

// Whether the two views could as well lie otherwise.
bool undetermined(const PoseLink& link) { return link.degenerate() || link.planar_only; }

// Best supported first, without those that are not believed: these confirm no others either.
// `loops_of_all`: of all links.
void sort_by_support(const std::vector<ViewSurface>& surfaces, const LinkLimits& limits,
                     const ViewGroupOptions& options, const std::vector<int>& loops_of_all,
                     std::vector<PoseLink>& links) {
  const auto fits = [&](const PoseLink& link, const VerificationThresholds& to) {
    return plausible(link.evidence, surfaces[link.a], surfaces[link.b],
                     link.off_plane_confirmed ? widened_coherent_limit(to, options.limits) : to);
  };
  std::vector<PoseLink> believed;
  for (std::size_t k = 0; k < links.size(); ++k)
    if (fits(links[k], loops_of_all[k] >= kTellingLoops ? limits.loop_confirmed : limits.confirmed))
      believed.push_back(links[k]);
  links = std::move(believed);
  const auto loops = count_loops(surfaces, links);
  const auto firm = [&](const PoseLink& link) {
    return fits(link, limits.lone) && !misses_coverage(link.evidence, limits.lone);
  };
  const auto stands_alone = [&](const PoseLink& link) {
    return firm(link) && link.evidence.overlap >= options.lone_overlap &&
           (link.off_plane_confirmed ||
            !misfits_locally(link.evidence, surfaces[link.a], surfaces[link.b], limits.confirmed));
  };
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < links.size(); ++k)
    if (loops[k] > 0 || stands_alone(links[k])) order.push_back(k);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
    const auto key = [&](std::size_t k) {
      return std::tuple(!undetermined(links[k]), firm(links[k]), loops[k] > 0,
                        links[k].evidence.overlap);
    };
    return key(x) > key(y);
  });
  std::vector<PoseLink> sorted;
  for (const std::size_t k : order) sorted.push_back(links[k]);
  links = std::move(sorted);
}

// One way of joining two groups.
struct MergeHypothesis {
  PoseLink link;
  RigidMotion first_from_second = RigidMotion::Identity();  // Frames of the groups.
  double support = 0.0;  // Sum of PairSupport over the pairs of views; above 0.
};

class Joining {
 public:
  Joining(const std::vector<ViewSurface>& surfaces, const std::vector<PoseLink>& links,
          const ViewGroups& start, const std::vector<bool>& known, const LinkLimits& limits,
          const ViewGroupOptions& options, JudgedPairs& judged)
      : surfaces_(surfaces),
        links_(links),
        pairs_(surfaces, links, limits, options, judged),
        options_(options),
        known_(known),
        start_sizes_(surfaces.size(), 0) {
    groups_.group = start.group;
    groups_.group_from_view = start.group_from_view;
    for (const std::size_t g : start.group) ++start_sizes_[g];
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
    const auto hypotheses = merge_hypotheses(first, second);
    if (hypotheses.empty() || ambiguous(hypotheses)) return false;
    const MergeHypothesis& best = hypotheses.front();
    if (undetermined(best.link)) return false;
    // The frame of known views stays, else that of the larger group from the start, else the one of
    // the first view.
    const bool move_first = claim(second) > claim(first);
    const RigidMotion motion =
        move_first ? best.first_from_second.inverse() : best.first_from_second;
    for (const std::size_t i : members(move_first ? first : second))
      groups_.group_from_view[i] = motion * groups_.group_from_view[i];
    std::replace(groups_.group.begin(), groups_.group.end(), second, first);
    groups_.joined.push_back(best.link);
    return true;
  }

  // What the frame of a group has for it: known views, and the most views that came together in it.
  std::pair<bool, std::size_t> claim(std::size_t of) const {
    std::pair<bool, std::size_t> claim(false, 1);
    for (const std::size_t i : members(of)) {
      claim.first |= known_[i];
      claim.second = std::max(claim.second, start_sizes_[i]);
    }
    return claim;
  }

  // The different ways in which links join the two groups that more speaks for than against, the
  // best supported first.
  std::vector<MergeHypothesis> merge_hypotheses(std::size_t first, std::size_t second) const {
    std::vector<MergeHypothesis> hypotheses;
    for (const auto& link : links_) {
      const bool forward = group(link.a) == first && group(link.b) == second;
      const bool backward = group(link.a) == second && group(link.b) == first;
      if (!forward && !backward) continue;
      MergeHypothesis hypothesis{link, groups_.group_from_view[link.a] * link.b_from_a.inverse() *
                                           groups_.group_from_view[link.b].inverse()};
      if (backward) hypothesis.first_from_second = hypothesis.first_from_second.inverse();
      const ViewSurface& moved = surfaces_[forward ? link.b : link.a];
      const RigidMotion& pose = groups_.group_from_view[forward ? link.b : link.a];
      const bool known =
          std::any_of(hypotheses.begin(), hypotheses.end(), [&](const MergeHypothesis& other) {
            return same_place(moved, hypothesis.first_from_second * pose,
                              other.first_from_second * pose);
          });
      if (!known) hypotheses.push_back(hypothesis);
    }
    for (MergeHypothesis& hypothesis : hypotheses)
      hypothesis.support = support(first, second, hypothesis);
    std::erase_if(hypotheses,
                  [](const MergeHypothesis& hypothesis) { return hypothesis.support <= 0.0; });
    std::stable_sort(
        hypotheses.begin(), hypotheses.end(),
        [](const MergeHypothesis& x, const MergeHypothesis& y) { return x.support > y.support; });
    return hypotheses;
  }

  bool ambiguous(const std::vector<MergeHypothesis>& hypotheses) const {
    return hypotheses.size() > 1 &&
           hypotheses[1].support >= options_.ambiguity * hypotheses[0].support;
  }

  double support(std::size_t first, std::size_t second, const MergeHypothesis& hypothesis) const {
    const auto of_first = members(first), of_second = members(second);
    const std::size_t pairs = of_first.size() * of_second.size();
    double sum = 0.0;
    // A pair that settles elsewhere refutes the hypothesis: the others need no look.
    for (std::size_t begin = 0; begin < pairs && std::isfinite(sum); begin += kPairsAtOnce) {
      const auto parts =
          parallel_map<double>(std::min(kPairsAtOnce, pairs - begin), [&](std::size_t k) {
            const std::size_t i = of_first[(begin + k) / of_second.size()],
                              j = of_second[(begin + k) % of_second.size()];
            return pairs_.support(i, j,
                                  groups_.group_from_view[i].inverse() *
                                      hypothesis.first_from_second * groups_.group_from_view[j]);
          });
      sum = std::accumulate(parts.begin(), parts.end(), sum);
    }
    return std::max(0.0, sum);
  }

  void report_ambiguous() {
    std::set<std::pair<std::size_t, std::size_t>> told;
    for (const auto& link : links_) {
      const auto key = groups_of(link);
      if (key.first == key.second || !told.insert(key).second) continue;
      const auto hypotheses = merge_hypotheses(key.first, key.second);
      if (hypotheses.empty()) continue;
      const PoseLink& best = hypotheses.front().link;
      if (ambiguous(hypotheses))
        groups_.ambiguous.push_back(
            {best.a, best.b, best.evidence.overlap, hypotheses[1].link.evidence.overlap});
      else if (undetermined(best))
        groups_.ambiguous.push_back({best.a, best.b, best.evidence.overlap, std::nullopt});
    }
  }

  const std::vector<ViewSurface>& surfaces_;
  const std::vector<PoseLink>& links_;
  const PairSupport pairs_;
  const ViewGroupOptions& options_;
  const std::vector<bool>& known_;
  std::vector<std::size_t> start_sizes_;  // Of the groups of the start, at their first views.
  std::map<std::pair<std::size_t, std::size_t>, std::pair<std::size_t, std::size_t>> refused_;
  ViewGroups groups_;
};

}  // namespace

bool ViewGroups::all_in_one() const {
  return std::all_of(group.begin(), group.end(), [](std::size_t g) { return g == 0; });
}

ViewGroups ViewGroups::singles(std::size_t views) {
  ViewGroups groups;
  groups.group.resize(views);
  std::iota(groups.group.begin(), groups.group.end(), std::size_t{0});
  groups.group_from_view.assign(views, RigidMotion::Identity());
  return groups;
}

ViewGroups join_views(const std::vector<ViewSurface>& surfaces, std::vector<PoseLink> links,
                      const ViewGroups& start, const std::vector<bool>& known,
                      const ViewGroupOptions& options, JudgedPairs& judged) {
  assert(start.group.size() == surfaces.size() && known.size() == surfaces.size());
  const std::vector<int> loops = count_loops(surfaces, links);
  const LinkLimits limits = fit_link_limits(surfaces, links, loops, options);
  sort_by_support(surfaces, limits, options, loops, links);
  return Joining(surfaces, links, start, known, limits, options, judged).run();
}

}  // namespace relief::registration
