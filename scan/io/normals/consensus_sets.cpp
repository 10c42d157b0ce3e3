#include "scan/io/normals/consensus_sets.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace relief {

namespace {

// Of `views`, those that `convention` is a candidate of.
ConsensusSet set_of(std::size_t convention, const ConsensusSet& views,
                    const std::vector<ConventionRanking>& alone) {
  ConsensusSet set;
  std::ranges::copy_if(views, std::back_inserter(set), [&](std::size_t view) {
    return std::ranges::binary_search(alone[view].candidates, convention);
  });
  return set;
}

double disagreement(std::size_t convention, const ConsensusSet& views,
                    const std::vector<ConventionRanking>& alone) {
  double sum = 0.0;
  for (const std::size_t view : views) sum += alone[view].disagreement[convention];
  return sum;
}

// Of equally large ones that which its convention fits best.
ConsensusSet largest_set(const ConsensusSet& views, const std::vector<ConventionRanking>& alone) {
  ConsensusSet largest;
  double least = 0.0;
  for (std::size_t c = 0; c < alone[views.front()].disagreement.size(); ++c) {
    ConsensusSet set = set_of(c, views, alone);
    const double sum = disagreement(c, set, alone);
    if (set.size() < largest.size() || (set.size() == largest.size() && !(sum < least))) continue;
    largest = std::move(set);
    least = sum;
  }
  return largest;
}

}  // namespace

ConventionRanking rank_alone(const NormalEvidence& view) {
  ConventionScores scores(view.kind);
  scores.add(view);
  ConventionRanking alone = scores.ranking();
  if (view.patches.patches.size() < kFewestPatches) return alone;
  const auto& all = all_conventions(view.kind);
  const auto bias = [&](std::size_t c) { return agreement(view, all[c]).bias; };
  if (std::ranges::any_of(alone.candidates, [&](std::size_t c) { return bias(c) < kLargestBias; }))
    std::erase_if(alone.candidates, [&](std::size_t c) { return bias(c) > kUnrelatedBias; });
  return alone;
}

std::vector<ConsensusSet> find_consensus_sets(const std::vector<ConventionRanking>& alone) {
  std::vector<ConsensusSet> sets;
  ConsensusSet left(alone.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  while (!left.empty()) {
    sets.push_back(largest_set(left, alone));
    std::erase_if(left,
                  [&](std::size_t view) { return std::ranges::binary_search(sets.back(), view); });
  }
  return sets;
}

}  // namespace relief
