#pragma once

#include <vector>

#include "relief/scan/grid.h"

namespace relief::rendering {

/// Colours from the lowest to the highest value.
using ColourMap = std::vector<Colour>;

/// Dark blue over green to yellow: of even steps to the eye, after viridis of Smith and van der
/// Walt (2015).
ColourMap sequential_map();

/// Blue over grey to red, for values with a sign (Moreland 2009).
ColourMap diverging_map();

/// The colour of `value` between `low` and `high`; those of the ends beyond.
Colour colour_at(const ColourMap& map, double value, double low, double high);

}  // namespace relief::rendering
