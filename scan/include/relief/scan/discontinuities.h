#pragma once

#include <cstdint>

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"

namespace relief {

/// Which neighbouring samples of a range view lie on one continuous surface.
struct GridEdges {
  Grid<std::uint8_t> right;  ///< 1: samples (u,v) and (u+1,v) are connected.
  Grid<std::uint8_t> down;   ///< 1: samples (u,v) and (u,v+1) are connected.

  /// Whether the sample at (u,v) is connected to its horizontal or vertical neighbour (u+du, v+dv).
  bool connected(int u, int v, int du, int dv) const {
    if (!right.contains(u, v) || !right.contains(u + du, v + dv)) return false;
    if (du == 1 && dv == 0) return right(u, v) != 0;
    if (du == -1 && dv == 0) return right(u - 1, v) != 0;
    if (du == 0 && dv == 1) return down(u, v) != 0;
    if (du == 0 && dv == -1) return down(u, v - 1) != 0;
    return false;
  }
  /// Whether the samples (u,v), (u+1,v), (u,v+1) and (u+1,v+1) are connected all round.
  bool connected_quad(int u, int v) const {
    return connected(u, v, 1, 0) && connected(u, v, 0, 1) && connected(u + 1, v, 0, 1) &&
           connected(u, v + 1, 1, 0);
  }
};

struct DiscontinuityOptions {
  /// An edge closer to the viewing ray than this is an occlusion edge, whatever its neighbours do.
  double grazing_angle_deg = 8.0;
  /// Steps along the ray up to this many lateral spacings are always taken as surface; larger ones
  /// only if the steps beside them are alike. Raised to four times the step noise of the view or,
  /// where it is larger, of the region; and by the step to which the ranges are rounded.
  double free_step = 2.0;
};

/// Connects neighbouring samples except across occlusion edges: steps along the ray that are large
/// against the lateral spacing and that neither a neighbouring slope nor the noise and the rounding
/// of the ranges explain (estimate_range_noise). The same for any number of threads.
GridEdges connect_samples(const RangeView& view, const DiscontinuityOptions& options = {});

}  // namespace relief
