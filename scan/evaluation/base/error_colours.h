#pragma once

#include <vector>

#include "relief/scan/grid.h"

namespace relief::evaluation {

/// Blue for -scale and less, light grey for 0, red for scale and more, linear between; values that
/// are not finite are black. `scale` > 0.
std::vector<Colour> colours_of_errors(const std::vector<double>& errors, double scale);

}  // namespace relief::evaluation
