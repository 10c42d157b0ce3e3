#include "registration/surface/bridged_view.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "scan/grid/small_gaps.h"

namespace relief::registration {

namespace {

// Gaps are bridged where more of the samples than this lie beside one. Fewer mean that one in a
// hundred is bridged. Two pixels round each take 24 % of the samples at most: less than
// kLostToGaps.
constexpr double kFewBesideGaps = 0.04;
// That is, if the gaps would otherwise take so large a part of the samples: gaps that the shape
// makes at creases and edges are better left open.
constexpr double kLostToGaps = 0.5;

// Whether a sample hangs together with no neighbour, as single wrong ranges inside a surface do.
bool is_stray(const RangeView& view, const GridEdges& edges, int u, int v) {
  return view.has_sample(u, v) && !edges.connected(u, v, 1, 0) && !edges.connected(u, v, -1, 0) &&
         !edges.connected(u, v, 0, 1) && !edges.connected(u, v, 0, -1);
}

// The ranges of a view with gaps in place of its strays.
RangeView without_strays(const RangeView& view, const GridEdges& edges) {
  RangeView rest;
  rest.camera = view.camera;
  rest.range = view.range;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (is_stray(view, edges, u, v)) rest.range(u, v) = kNoSample;
  return rest;
}

// The view with those ranges, and its own where these are none: strays beyond any surface.
RangeView with_ranges(const RangeView& view, Grid<double> ranges,
                      const Grid<std::uint8_t>& bridged) {
  RangeView whole;
  whole.name = view.name;
  whole.camera = view.camera;
  whole.range = std::move(ranges);
  for (std::size_t i = 0; i < whole.range.size(); ++i)
    if (std::isnan(whole.range[i])) whole.range[i] = view.range[i];
  whole.normals = view.normals;
  whole.confidence = view.confidence;
  whole.deviation = view.deviation;
  whole.samples = view.samples;
  for (std::size_t i = 0; i < whole.confidence.size(); ++i)
    if (bridged[i]) whole.confidence[i] = 1.0f;
  return whole;
}

}  // namespace

std::optional<BridgedView> bridge_gaps(const RangeView& view, const RangeNoise& noise,
                                       const ConnectedGrid& grid, int margin) {
  const auto samples = static_cast<double>(view.sample_count());
  const auto inner = [&](const ConnectedGrid& of, const Grid<std::uint8_t>& bridged) {
    double count = 0.0;
    for (std::size_t i = 0; i < of.boundary.size(); ++i)
      count += (bridged.empty() || !bridged[i]) && of.boundary[i] >= margin ? 1.0 : 0.0;
    return count;
  };
  // No bridging gives more inner samples than there are samples.
  const double inner_as_given = inner(grid, {});
  if (inner_as_given > (1.0 - kLostToGaps) * samples) return std::nullopt;
  BridgedRange filled = bridge_small_gaps(without_strays(view, grid.edges), {.sigma = noise.sigma});
  // Each bridged sample has about four measured ones beside it.
  if (4.0 * static_cast<double>(filled.bridged_count) < kFewBesideGaps * samples)
    return std::nullopt;
  BridgedView result{with_ranges(view, std::move(filled.range), filled.bridged), {}, {}};
  result.grid = connect_grid(result.view);
  if (inner_as_given > (1.0 - kLostToGaps) * inner(result.grid, filled.bridged))
    return std::nullopt;
  result.bridged = std::move(filled.bridged);
  return result;
}

}  // namespace relief::registration
