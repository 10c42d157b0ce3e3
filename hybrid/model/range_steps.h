#pragma once

#include <optional>

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"

namespace relief::hybrid {

/// The step between two neighbouring samples with normals, lengths along the ray [unit].
struct RangeStep {
  double expected = 0.0;  ///< What the mean of both normals asks for, equation (H4) solved for it.
  double discrepancy = 0.0;  ///< The measured step less the expected one.
  double sensitivity = 0.0;  ///< Change of the expected step per radian of slope error [unit/rad].
  double incidence = 0.0;    ///< Cosine between the mean normal and the direction to the sensor.
};

/// The step from the sample at (u, v) to that at (u+du, v+dv); nothing where one of them has no
/// normal or the sensor sees the surface edge-on.
std::optional<RangeStep> range_step(const RangeView& view, int u, int v, int du, int dv);

/// For every connected grid edge whose two ends have normals, lengths along the ray [unit]; NaN on
/// all others. (u,v) of `along rows` is the edge to (u+1,v), of `along columns` to (u,v+1).
struct RangeSteps {
  struct Direction {
    Grid<float> expected, discrepancy, sensitivity;  ///< See RangeStep.
    int factor = 1;  ///< Samples along the side of the blocks that the steps lead between.
  };
  Direction along_rows, along_columns;
};

RangeSteps range_steps(const RangeView& view, const GridEdges& edges);

}  // namespace relief::hybrid
