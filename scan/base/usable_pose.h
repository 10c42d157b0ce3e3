#pragma once

#include <cstddef>

#include "relief/scan/range_view.h"

namespace relief {

/// Whether a view can take part in a model of `views` views: a single view has nothing to be
/// aligned with, and any pose serves.
inline bool has_usable_pose(const RangeView& view, std::size_t views) {
  return views == 1 || view.pose != PoseKind::kAbsent;
}

}  // namespace relief
