#include "registration/posegraph/refinement/cluster_scores.h"

#include <algorithm>
#include <functional>
#include <map>
#include <queue>
#include <utility>

#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// The cube of the lattice four times as wide that holds a cube; see patch_of().
std::uint64_t around(std::uint64_t patch) {
  static_assert(ClusterScores::kLarger == 4.0);
  std::uint64_t key = 0;
  for (int k = 0; k < 3; ++k) key |= ((patch >> (21 * k) & 0x1fffffU) >> 2) << (21 * k);
  return key;
}

// Adds scores, times `sign`, to sums; both are in ascending order of their patches.
void add_to(PagedVector<PatchScore>& sums, std::span<const PatchScore> scores, double sign) {
  const std::size_t before = sums.size();
  std::size_t from = 0;
  for (const PatchScore& score : scores) {
    const auto end = sums.begin() + static_cast<std::ptrdiff_t>(before);
    const auto place = std::ranges::lower_bound(sums.begin() + static_cast<std::ptrdiff_t>(from),
                                                end, score.patch, {}, &PatchScore::patch);
    from = static_cast<std::size_t>(place - sums.begin());
    if (place != end && place->patch == score.patch)
      place->score += sign * score.score;
    else
      sums.push_back({score.patch, sign * score.score});
  }
  std::ranges::inplace_merge(sums, sums.begin() + static_cast<std::ptrdiff_t>(before), {},
                             &PatchScore::patch);
}

// Clusters between two looks at the memory. Changes no result.
constexpr std::size_t kClustersAtOnce = 1024;

}  // namespace

PagedVector<PatchScore> ClusterScores::larger(std::span<const PatchScore> patches) {
  std::map<std::uint64_t, RigidTangent> sums;
  for (const PatchScore& patch : patches)
    sums.try_emplace(around(patch.patch), RigidTangent::Zero()).first->second += patch.score;
  PagedVector<PatchScore> joined;
  joined.reserve(sums.size());
  for (const auto& [patch, score] : sums) joined.push_back({patch, score});
  return joined;
}

void ClusterScores::add(const PairInformation& pair) {
  add_to(of_view_[pair.source], pair.patches, 1.0);
  add_to(of_view_[pair.target], pair.patches, -1.0);
}

ClusterScores ClusterScores::on_larger_clusters() const {
  ClusterScores joined(of_view_.size());
  for (std::size_t view = 0; view < of_view_.size(); ++view) {
    check_stop_and_memory();
    joined.of_view_[view] = larger(of_view_[view]);
  }
  return joined;
}

void ClusterScores::for_each_cluster(
    const std::function<void(std::uint64_t, std::span<const Entry>)>& visit) const {
  using Next = std::pair<std::uint64_t, std::size_t>;  // The next patch of a view.
  std::priority_queue<Next, std::vector<Next>, std::greater<>> next;
  std::vector<std::size_t> visited(of_view_.size(), 0);
  const auto go_on_with = [&](std::size_t view) {
    if (visited[view] < of_view_[view].size())
      next.emplace(of_view_[view][visited[view]].patch, view);
  };
  for (std::size_t view = 0; view < of_view_.size(); ++view) go_on_with(view);
  std::vector<Entry> entries;
  for (std::size_t clusters = 0; !next.empty(); ++clusters) {
    if (clusters % kClustersAtOnce == 0) check_stop_and_memory();
    const std::uint64_t patch = next.top().first;
    entries.clear();
    while (!next.empty() && next.top().first == patch) {
      const std::size_t view = next.top().second;
      next.pop();
      entries.push_back({view, of_view_[view][visited[view]++].score});
      go_on_with(view);
    }
    visit(patch, entries);
  }
}

}  // namespace relief::registration
