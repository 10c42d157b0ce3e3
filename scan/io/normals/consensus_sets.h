#pragma once

#include <cstddef>
#include <vector>

#include "scan/io/normals/convention_scores.h"
#include "scan/io/normals/normal_evidence.h"

namespace relief {

/// What the depth of one view says alone. A convention so far from it that the map would belong to
/// another depth is no candidate where another one fits: such a view is small, not ambiguous.
ConventionRanking rank_alone(const NormalEvidence& view);

/// Views, by their indices in ascending order, that have a candidate in common.
using ConsensusSet = std::vector<std::size_t>;

/// Divides the views of these rankings into consensus sets, each as large as it can be of those
/// that are left: a view that alone cannot tell is with the most others. Nearly always all are one
/// set.
std::vector<ConsensusSet> find_consensus_sets(const std::vector<ConventionRanking>& alone);

}  // namespace relief
