#pragma once

#include "relief/rendering/picture.h"
#include "relief/scan/range_view.h"

namespace relief {

/// The samples of a view on their grid, matte and lit from the upper left: relief and noise show.
/// At most `width` pixels wide: every so many samples give one pixel, which shows the slope from
/// that sample to those next to it. White where there is none.
rendering::Picture shaded_samples(const RangeView& view, int width);

}  // namespace relief
