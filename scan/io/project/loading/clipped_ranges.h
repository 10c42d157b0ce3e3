#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "relief/scan/range_view.h"

namespace relief {

/// Samples of a view that all have exactly its smallest or its largest depth.
struct ClippedRanges {
  std::string view;
  std::size_t count = 0, samples = 0;  ///< Of them, and of all.
  double limit = 0.0;                  ///< Their depth [unit].
  bool is_nearest = false;             ///< Or else the largest.
};

/// Many samples with exactly the smallest or the largest depth, far more than have the next one: as
/// where a sensor writes the limit of its range for all that is beyond. Nothing where there are
/// none.
std::optional<ClippedRanges> find_clipped_ranges(const RangeView& view);

/// Names the first of these views, `clipped` of `views` in all. Such samples are not left out,
/// since a flat surface that faces a sensor without noise looks alike. Nothing where there is none.
std::optional<std::string> note_on_clipped_ranges(const std::vector<ClippedRanges>& clipped,
                                                  std::size_t views);

}  // namespace relief
