#include "scan/io/normals/convention_parties.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace relief {

namespace {

// Of `views`, those that `convention` is a candidate of.
Party party_of(std::size_t convention, const Party& views,
               const std::vector<ConventionRanking>& alone) {
  Party party;
  std::ranges::copy_if(views, std::back_inserter(party), [&](std::size_t view) {
    return std::ranges::binary_search(alone[view].candidates, convention);
  });
  return party;
}

double disagreement(std::size_t convention, const Party& views,
                    const std::vector<ConventionRanking>& alone) {
  double sum = 0.0;
  for (const std::size_t view : views) sum += alone[view].disagreement[convention];
  return sum;
}

// Of equally large ones that which its convention fits best.
Party largest_party(const Party& views, const std::vector<ConventionRanking>& alone) {
  Party largest;
  double least = 0.0;
  for (std::size_t c = 0; c < alone[views.front()].disagreement.size(); ++c) {
    Party party = party_of(c, views, alone);
    const double sum = disagreement(c, party, alone);
    if (party.size() < largest.size() || (party.size() == largest.size() && !(sum < least)))
      continue;
    largest = std::move(party);
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

std::vector<Party> find_parties(const std::vector<ConventionRanking>& alone) {
  std::vector<Party> parties;
  Party left(alone.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  while (!left.empty()) {
    parties.push_back(largest_party(left, alone));
    std::erase_if(
        left, [&](std::size_t view) { return std::ranges::binary_search(parties.back(), view); });
  }
  return parties;
}

}  // namespace relief
