#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "registration/global/features/local_features.h"

namespace relief::registration {

/// All pairs of views (a < b) in the order in which it pays to compare them: those first whose
/// local shapes are alike as a whole. Each view's features are counted by kind, rare kinds weighing
/// more (Sivic and Zisserman 2003); then every view in turn names the most similar one left, so
/// that none waits for others. The cost per pair is that of comparing two short histograms. Views
/// without features come last.
std::vector<std::pair<std::size_t, std::size_t>> rank_pairs(
    const std::vector<const LocalFeatures*>& views);

}  // namespace relief::registration
