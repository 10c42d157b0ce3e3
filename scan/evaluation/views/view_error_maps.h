#pragma once

#include <string>

#include "relief/scan/grid.h"
#include "scan/evaluation/views/view_pairs.h"

namespace relief::evaluation {

/// The errors of one view at each pixel; NaN where there is none.
struct ViewErrorMaps {
  std::string name;
  Grid<float> depth;                 ///< Equation (E3) [unit].
  Grid<float> position_normals_deg;  ///< Angle to the true normal [degrees].
  Grid<float> map_normals_deg;       ///< The same; empty without a normal map.
};

/// The errors that evaluate_views summarises.
ViewErrorMaps error_maps(const ViewAndTruth& pair);

}  // namespace relief::evaluation
