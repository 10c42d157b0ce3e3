#include "registration/posegraph/refinement/cluster_scores.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace relief::registration {

namespace {

// The cube of the lattice four times as wide that holds a cube; see patch_of().
std::uint64_t around(std::uint64_t patch) {
  static_assert(ClusterScores::kLarger == 4.0);
  std::uint64_t key = 0;
  for (int k = 0; k < 3; ++k) key |= ((patch >> (21 * k) & 0x1fffffU) >> 2) << (21 * k);
  return key;
}

}  // namespace

std::vector<PatchScore> ClusterScores::larger(const std::vector<PatchScore>& patches) {
  std::map<std::uint64_t, RigidTangent> sums;
  for (const PatchScore& patch : patches)
    sums.try_emplace(around(patch.patch), RigidTangent::Zero()).first->second += patch.score;
  std::vector<PatchScore> joined;
  for (const auto& [patch, score] : sums) joined.push_back({patch, score});
  return joined;
}

void ClusterScores::add(const PairInformation& pair) {
  for (const PatchScore& patch : pair.patches) {
    of_view_[pair.source].try_emplace(patch.patch, RigidTangent::Zero()).first->second +=
        patch.score;
    of_view_[pair.target].try_emplace(patch.patch, RigidTangent::Zero()).first->second -=
        patch.score;
  }
}

ClusterScores ClusterScores::on_larger_clusters() const {
  ClusterScores larger(of_view_.size());
  for (const Entry& entry : sorted())
    larger.of_view_[entry.view]
        .try_emplace(around(entry.patch), RigidTangent::Zero())
        .first->second += entry.score;
  return larger;
}

std::vector<ClusterScores::Entry> ClusterScores::sorted() const {
  std::size_t count = 0;
  for (const auto& scores : of_view_) count += scores.size();
  std::vector<Entry> entries;
  entries.reserve(count);
  for (std::size_t view = 0; view < of_view_.size(); ++view)
    for (const auto& [patch, score] : of_view_[view]) entries.push_back({patch, view, score});
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.patch, a.view) < std::tie(b.patch, b.view);
  });
  return entries;
}

}  // namespace relief::registration
