#pragma once

#include <cstdint>
#include <optional>

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/range_noise.h"

namespace relief::registration {

/// A view whose small gaps are bridged.
struct BridgedView {
  RangeView view;
  ConnectedGrid grid;
  Grid<std::uint8_t> bridged;  ///< 1: interpolated, not measured.
};

/// Bridges the small gaps of a view, and the places of samples that hang together with no
/// neighbour, as single wrong ranges inside a surface do. What looks at whole neighbourhoods of
/// pixels would lose all samples beside them. Nothing where they take less than half of the samples
/// that are at least `margin` [pixels] from a boundary. `grid` is that of the view.
std::optional<BridgedView> bridge_gaps(const RangeView& view, const RangeNoise& noise,
                                       const ConnectedGrid& grid, int margin);

}  // namespace relief::registration
