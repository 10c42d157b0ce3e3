#pragma once

#include <cstddef>
#include <cstdint>

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"

namespace relief {

struct SmallGapOptions {
  /// Most pixels without a sample between two samples of one row or column; >= 1 [pixels].
  int widest = 3;
  /// A surface may rise by this much along the ray per unit of lateral distance; > 0. 2 is
  /// 63 degrees.
  double steepest = 2.0;
  /// Standard deviation of the ranges along the rays [unit]: so much more may the ends of a gap
  /// differ. 0: exact ranges.
  double sigma = 0.0;
};

/// The ranges of a view with its small gaps filled.
struct BridgedRange {
  Grid<double> range;          ///< Those of the view, and interpolated ones in small gaps [unit].
  Grid<std::uint8_t> bridged;  ///< 1: interpolated, not measured.
  std::size_t bridged_count = 0;
};

/// Interpolates the ranges of pixels without a sample that lie between samples of one surface:
/// sensors lose single samples everywhere, and what looks at whole neighbourhoods of pixels would
/// lose all of them. A gap is bridged along its row or column, or both, where the samples at its
/// ends differ by no more than a surface of `steepest` slope and noise explain. So are the
/// crossings of such gaps, which depth maps have that were carried into the image of a finer
/// camera. Wider gaps and occlusion edges stay as they are. Nothing else of the view is looked at.
BridgedRange bridge_small_gaps(const RangeView& view, const SmallGapOptions& options = {});

}  // namespace relief
