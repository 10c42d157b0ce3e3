#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"

namespace relief::hybrid {

struct ScreenedNormals {
  Grid<Eigen::Vector3f> normals;  ///< Isolated ones replaced by the median of their neighbourhood.
  Grid<std::uint8_t> isolated;    ///< 1 where replaced.
  std::size_t count = 0;          ///< Of those.
};

/// Replaces single wild normals (highlights, shadow edges, dead pixels; up to about a third of
/// all). A normal is isolated if it lies further from the median normal of its 5 x 5 neighbourhood
/// than four times the typical distance there and in the whole view: creases and steps are not.
ScreenedNormals screen_normals(const RangeView& view);

}  // namespace relief::hybrid
