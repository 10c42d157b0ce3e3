#pragma once

#include <algorithm>

#include "relief/scan/range_view.h"

namespace relief {

/// The steps in which a sensor rounds its ranges. Disparity sensors round the inverse of the range,
/// often before they write it in whole units: then both steps are there.
struct RangeQuantisation {
  double step = 0.0;          ///< Of t, or of the distance along the ray [unit]; 0: none.
  double inverse_step = 0.0;  ///< Of the inverse of the same [1/unit]; 0: none.
  bool along_ray = false;     ///< The distance |d| t along the ray is rounded, not t.

  bool exists() const { return step > 0.0 || inverse_step > 0.0; }
  /// The step of the position along the ray [unit] of a sample at `range` t, on a ray whose
  /// direction has the length `metric`.
  double step_at(double range, double metric) const {
    const double t = along_ray ? metric * range : range;
    return (along_ray ? 1.0 : metric) * std::max(step, inverse_step * t * t);
  }
};

/// Finds the step of the ranges of a view, or of their inverses, from the differences of
/// neighbouring samples: those of rounded ranges are whole multiples of the step. Where ranges were
/// interpolated afterwards, the step of the inverse is found between runs of equal ranges. None is
/// found where it is so small that it hides in the rounding of single precision.
RangeQuantisation find_quantisation(const RangeView& view);

}  // namespace relief
