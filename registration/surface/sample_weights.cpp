#include "registration/surface/sample_weights.h"

#include <algorithm>

#include "scan/base/median_deviation.h"

namespace relief::registration {

namespace {

// Squares of `typical` over the deviation of each sample, times its confidence.
template <typename Deviation>
Grid<float> inverse_variances(const RangeView& view, double typical, const Deviation& deviation) {
  Grid<float> weights(view.width(), view.height(), 0.0f);
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      weights(u, v) = view.confidence_at(u, v);
      const double ratio = typical / deviation(u, v);
      if (weights(u, v) > 0.0f && ratio >= 0.0) weights(u, v) = static_cast<float>(ratio * ratio);
    }
  }
  return weights;
}

}  // namespace

Grid<float> sample_weights(const RangeView& view, const RangeNoise& ranges) {
  if (view.samples == SampleOrigin::kRefined) return {};
  if (const double typical = median_deviation(view); typical > 0.0)
    return inverse_variances(view, typical, [&](int u, int v) { return view.deviation_at(u, v); });
  if (ranges.map.empty() || !ranges.known()) return {};
  auto weights = inverse_variances(view, ranges.sigma, [&](int u, int v) {
    return std::max(ranges.sigma, ranges.sigma_at(u, v));
  });
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u) weights(u, v) *= view.confidence_at(u, v);
  return weights;
}

}  // namespace relief::registration
