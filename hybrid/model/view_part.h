#pragma once

#include <cstddef>

#include "relief/scan/range_view.h"

namespace relief::hybrid {

/// A rectangle of the pixels of a view.
struct ViewPart {
  int u = 0, v = 0;  ///< Of its upper left pixel.
  int width = 0, height = 0;

  std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }
};

/// A rectangle with all samples of a view and so many pixels around them, or up to 7 more, as far
/// as the grid goes; of no pixel for a view without samples.
ViewPart part_with_samples(const RangeView& view, int margin);

/// The part of a view that refine_view() works on: its samples and what its steps look at around
/// them, or all of it where the rest is little or where there is no sample.
ViewPart part_to_refine(const RangeView& view);

/// That part alone, with the same rays. Cameras but pinholes and orthographic ones become tables of
/// rays, and cannot project.
RangeView crop(const RangeView& view, const ViewPart& part);

/// `whole` with ranges, normals, colours, confidences and deviations of its part, and all else as
/// the part has it but its camera. Outside, confidences are those of the whole, and deviations
/// unknown.
RangeView with_part(const RangeView& whole, const ViewPart& part, RangeView refined);

}  // namespace relief::hybrid
