#pragma once

#include <cstddef>
#include <cstdint>

#include "hybrid/model/range_steps.h"
#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "scan/grid/range_noise.h"

namespace relief::hybrid {

/// A view as refining it needs it: without flying samples, small gaps filled, and with how much
/// each range counts. Flying samples that lie with one of their neighbours leave a gap, and gaps
/// beside an occlusion edge stay: they may be of another surface than the one that would fill them.
struct PreparedView {
  /// Filled samples have no confidence: they follow their neighbours and normals. The others'
  /// confidence, or their deviation where known, is as measured until count_by_noise.
  RangeView view;
  GridEdges measured_edges;  ///< Between measured samples.
  GridEdges edges;           ///< Of the view with its gaps filled.
  RangeNoise noise;          ///< Of the ranges as measured.
  /// Variance of each range over that of a typical one, by count_by_noise; empty: 1 everywhere.
  Grid<float> variance;
  std::size_t flying = 0, filled = 0;  ///< See FilledView.

  /// Confidences and deviations as measured, of filled samples those of their neighbours.
  Grid<float> confidence, deviation;
};

/// Makes the ranges of samples marked 1 count nothing.
void take_confidence(const Grid<std::uint8_t>& samples, RangeView& view);

/// Whether the map of a view's noise, which must not be empty, shows as well in what its normals do
/// not explain of the steps of its ranges: fine relief looks like noise from ranges alone.
bool confirms(const RangeSteps& steps, const Grid<float>& map);

/// Divides the confidence of each range by its variance over that of a typical one, as the map of
/// its noise tells, which must not be empty.
void count_by_noise(PreparedView& prepared);

PreparedView prepare_view(const RangeView& view, const DiscontinuityOptions& options);

}  // namespace relief::hybrid
