#include "registration/patch_pulls.h"

#include <algorithm>
#include <tuple>

namespace relief {

void PatchPulls::add(const PairInformation& pair) {
  for (const PatchPull& patch : pair.patches) {
    of_view_[pair.source].try_emplace(patch.patch, RigidTangent::Zero()).first->second +=
        patch.pull;
    of_view_[pair.target].try_emplace(patch.patch, RigidTangent::Zero()).first->second -=
        patch.pull;
  }
}

std::vector<PatchPulls::Entry> PatchPulls::sorted() const {
  std::vector<Entry> entries;
  for (std::size_t view = 0; view < of_view_.size(); ++view)
    for (const auto& [patch, pull] : of_view_[view]) entries.push_back({patch, view, pull});
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.patch, a.view) < std::tie(b.patch, b.view);
  });
  return entries;
}

}  // namespace relief
