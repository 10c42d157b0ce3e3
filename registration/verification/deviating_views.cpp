#include "registration/verification/deviating_views.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include "registration/pairwise/robust.h"
#include "registration/posegraph/view_graph.h"

namespace relief::registration {

namespace {

// Pairs that deviate, and all others, at least: by chance the two largest of eight are of one view
// in 1 of 28 cases.
constexpr std::size_t kFewestDeviating = 2, kFewestOthers = 6;

double median_of(std::span<const RelativeDeviation> deviations) {
  std::vector<double> values;
  for (const RelativeDeviation& pair : deviations) values.push_back(pair.rms);
  return quantile(std::move(values), 0.5);
}

bool deviates_alone(std::size_t view, const std::vector<RelativeDeviation>& deviations) {
  std::vector<double> own, others;
  for (const auto& [a, b, rms] : deviations) (a == view || b == view ? own : others).push_back(rms);
  return own.size() >= kFewestDeviating && others.size() >= kFewestOthers &&
         std::ranges::min(own) > std::ranges::max(others) &&
         quantile(std::move(own), 0.5) > kUncommon * quantile(std::move(others), 0.5);
}

// Of pairs in the order of their deviations how many come before the widest gap between two.
std::size_t widest_gap(const std::vector<RelativeDeviation>& sorted) {
  std::size_t widest = kFewestOthers;
  const auto rise = [&](std::size_t k) { return sorted[k].rms / sorted[k - 1].rms; };
  for (std::size_t k = kFewestOthers; k + kFewestDeviating <= sorted.size(); ++k)
    if (rise(k) > rise(widest)) widest = k;
  return widest;
}

std::vector<std::size_t> groups_of(std::size_t views, std::span<const RelativeDeviation> pairs) {
  std::vector<ViewPair> links;
  for (const auto& [a, b, unused] : pairs) links.push_back({a, b, 1.0});
  return connected_groups(views, links);
}

std::size_t largest_group(const std::vector<std::size_t>& group) {
  std::map<std::size_t, std::size_t> sizes;
  for (const std::size_t g : group) ++sizes[g];
  return std::ranges::max_element(sizes,
                                  [](const auto& x, const auto& y) { return x.second < y.second; })
      ->first;
}

std::vector<bool> deviate_with_group(std::size_t views, std::vector<RelativeDeviation> deviations) {
  std::vector<bool> result(views, false);
  if (deviations.size() < kFewestOthers + kFewestDeviating) return result;
  std::ranges::stable_sort(deviations, {}, &RelativeDeviation::rms);
  const std::size_t gap = widest_gap(deviations);
  const std::span all(deviations), within = all.first(gap), between = all.subspan(gap);
  if (!(median_of(between) > kUncommon * median_of(within))) return result;
  const auto group = groups_of(views, within);
  if (std::ranges::any_of(between,
                          [&](const auto& pair) { return group[pair.a] == group[pair.b]; }))
    return result;
  const std::size_t main = largest_group(group);
  std::map<std::size_t, std::size_t> pairs_with_main;  // By group.
  for (const RelativeDeviation& pair : between) {
    if (group[pair.a] == main) ++pairs_with_main[group[pair.b]];
    if (group[pair.b] == main) ++pairs_with_main[group[pair.a]];
  }
  for (std::size_t i = 0; i < views; ++i) result[i] = pairs_with_main[group[i]] >= kFewestDeviating;
  return result;
}

}  // namespace

DeviatingViews find_deviating_views(std::size_t views,
                                    const std::vector<RelativeDeviation>& deviations) {
  DeviatingViews found{{}, deviate_with_group(views, deviations)};
  for (std::size_t i = 0; i < views; ++i) found.alone.push_back(deviates_alone(i, deviations));
  return found;
}

}  // namespace relief::registration
