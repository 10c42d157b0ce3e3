#pragma once

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"

namespace relief::hybrid {

/// For every connected grid edge whose two ends have normals, lengths along the ray [unit]; NaN on
/// all others. (u,v) of `along rows` is the edge to (u+1,v), of `along columns` to (u,v+1).
struct RangeSteps {
  struct Direction {
    Grid<float> expected;     ///< The step that the normals imply, equation (H4) solved for it.
    Grid<float> discrepancy;  ///< The measured step less the expected one.
    Grid<float> sensitivity;  ///< Change of the expected step per radian of slope error [unit/rad].
    int factor = 1;           ///< Samples along the side of the blocks that the steps lead between.
  };
  Direction along_rows, along_columns;
};

RangeSteps range_steps(const RangeView& view, const GridEdges& edges, int threads = 1);

}  // namespace relief::hybrid
