#include "registration/calibration/calibration_input.h"

#include <cstddef>

namespace relief::registration {

namespace {

// Pairs with the largest overlaps of a view that are used. Bounds time and memory.
constexpr int kMostPairsOfAView = 8;

}  // namespace

std::vector<ViewPair> fitting_pairs(const Alignment& aligned) {
  std::vector<ViewPair> pairs;
  for (const PairFit& fit : aligned.pairs)
    if (fit.status != PairStatus::kMisfit && aligned.views[fit.a].aligned &&
        aligned.views[fit.b].aligned)
      pairs.push_back({fit.a, fit.b, fit.overlap});
  return largest_overlaps(aligned.views.size(), pairs, kMostPairsOfAView);
}

std::vector<bool> held_views(const std::vector<RangeView>& views,
                             const std::vector<ViewPair>& pairs) {
  const auto group = connected_groups(views.size(), pairs);
  std::vector<bool> held(views.size()), has_held(views.size(), false);
  for (std::size_t i = 0; i < views.size(); ++i) {
    held[i] = views[i].pose == PoseKind::kKnown;
    if (held[i]) has_held[group[i]] = true;
  }
  for (std::size_t i = 0; i < views.size(); ++i)
    if (group[i] == i && !has_held[i]) held[i] = true;
  return held;
}

bool shape_holds_all(const Alignment& aligned) {
  std::vector<bool> paired(aligned.views.size(), false), held(aligned.views.size(), false);
  for (const PairFit& fit : aligned.pairs)
    for (const std::size_t view : {fit.a, fit.b}) {
      paired[view] = true;
      held[view] = held[view] || fit.degenerate_directions.empty();
    }
  return paired == held;
}

RangeView ranges_of(const RangeView& view) {
  RangeView ranges;
  ranges.name = view.name;
  ranges.camera = view.camera;
  ranges.range = view.range;
  ranges.confidence = view.confidence;
  ranges.deviation = view.deviation;
  ranges.samples = view.samples;
  return ranges;
}

}  // namespace relief::registration
