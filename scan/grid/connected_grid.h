#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "scan/grid/range_noise.h"

namespace relief {

/// As connect_samples() of the view alone, with its noise that the caller has estimated already.
GridEdges connect_samples(const RangeView& view, const RangeNoise& noise,
                          const DiscontinuityOptions& options = {});

/// Chessboard distance [pixels] of each sample to the nearest pixel that has no sample or is cut
/// off by an occlusion edge, or to the border of the grid: 0 on such boundary samples themselves
/// and where there is no sample, capped at 255.
Grid<std::uint8_t> boundary_distance(const RangeView& view, const GridEdges& edges);

/// A view's samples with how they hang together, found once for several uses.
struct ConnectedGrid {
  Grid<Eigen::Vector3d> points;  ///< See points_of.
  GridEdges edges;               ///< See connect_samples.
  Grid<std::uint8_t> boundary;   ///< See boundary_distance.
};

ConnectedGrid connect_grid(const RangeView& view);
ConnectedGrid connect_grid(const RangeView& view, const RangeNoise& noise);

}  // namespace relief
