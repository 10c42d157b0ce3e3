#include "registration/posegraph/dense/cluster_scores.h"

#include <algorithm>
#include <tuple>

namespace relief::registration {

namespace {

// The cube of the lattice four times as wide that holds a cube; see patch_of().
std::uint64_t around(std::uint64_t patch) {
  static_assert(PatchPulls::kLarger == 4.0);
  std::uint64_t key = 0;
  for (int k = 0; k < 3; ++k) key |= ((patch >> (21 * k) & 0x1fffffU) >> 2) << (21 * k);
  return key;
}

}  // namespace

void PatchPulls::add(const PairInformation& pair) {
  for (const PatchPull& patch : pair.patches) {
    of_view_[pair.source].try_emplace(patch.patch, RigidTangent::Zero()).first->second +=
        patch.pull;
    of_view_[pair.target].try_emplace(patch.patch, RigidTangent::Zero()).first->second -=
        patch.pull;
  }
}

PatchPulls PatchPulls::on_larger_patches() const {
  PatchPulls larger(of_view_.size());
  for (const Entry& entry : sorted())
    larger.of_view_[entry.view]
        .try_emplace(around(entry.patch), RigidTangent::Zero())
        .first->second += entry.pull;
  return larger;
}

std::vector<PatchPulls::Entry> PatchPulls::sorted() const {
  std::size_t count = 0;
  for (const auto& pulls : of_view_) count += pulls.size();
  std::vector<Entry> entries;
  entries.reserve(count);
  for (std::size_t view = 0; view < of_view_.size(); ++view)
    for (const auto& [patch, pull] : of_view_[view]) entries.push_back({patch, view, pull});
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.patch, a.view) < std::tie(b.patch, b.view);
  });
  return entries;
}

}  // namespace relief::registration
