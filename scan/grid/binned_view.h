#pragma once

#include <optional>

#include "relief/scan/range_view.h"

namespace relief {

/// Median distance of samples beside each other in some of the rows [unit]: quick, and too large
/// where ranges are noisy; 0 without any.
double rough_spacing(const RangeView& view);

/// The view as a sensor with pixels `factor` times as large would have it. A large pixel has a
/// sample where half of its pixels have one on the same surface: the value in its middle of the
/// plane through their ranges. It has their mean confidence and colour, and the direction of their
/// mean normal. Deviations are those of the mean: of refined samples, whose errors neighbours
/// share, the mean of theirs. Rows and columns that fill no large pixel are left out. Nothing where
/// the camera has no such larger pixels (Camera::binned), or fewer than two rows or columns of
/// them.
std::optional<RangeView> bin_view(const RangeView& view, int factor);

}  // namespace relief
