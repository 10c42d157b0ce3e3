#pragma once

#include <cstddef>
#include <cstdint>

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"

namespace relief {

struct FillOptions {
  int widest_gap = 3;      ///< See SmallGapOptions.
  int largest_flying = 4;  ///< Most samples that hang in the air together; 0: none are looked for.
  /// Standard deviation of the positions along the rays [unit]; 0: estimate_range_noise tells.
  double sigma = 0.0;
};

/// A view without its flying samples and without its small gaps.
struct FilledView {
  RangeView view;
  Grid<std::uint8_t> filled;     ///< 1: interpolated, not measured here.
  std::size_t filled_count = 0;  ///< Of those.
  std::size_t flying = 0;        ///< Measured samples that were taken away; most are filled, too.
};

/// 1 for samples that hang in the air: small groups cut off by steps from all samples beside them.
/// There are some: islands between missing samples do not fly.
Grid<std::uint8_t> flying_samples(const RangeView& view, const GridEdges& edges,
                                  int largest_flying = FillOptions().largest_flying);

/// Takes away flying samples and fills small gaps on one surface. A gap, pixels without samples
/// that hang together along rows and columns, is filled as a whole or not at all: where
/// bridge_small_gaps bridges all of its pixels, and at least half of the 5 x 5 pixels round each
/// have samples. Lines of missing samples one pixel wide are filled on their own where they make a
/// lattice: more than a tenth of the samples, with two fifths of the pixels around measured. A
/// filled pixel has its own normal if there is one, else one interpolated from those that its range
/// follows from: across one missing sample by a cubic through two on either side, else their mean.
/// It has the means of their confidences, deviations and colours.
FilledView fill_small_gaps(const RangeView& view, const FillOptions& options = {});
/// The same where the edges of the view are at hand.
FilledView fill_small_gaps(const RangeView& view, const GridEdges& edges,
                           const FillOptions& options = {});

}  // namespace relief
