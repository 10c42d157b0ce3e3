#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace relief {

using Rgb = std::array<std::uint8_t, 3>;

/// Blue for -scale and less, light grey for 0, red for scale and more, linear between; values that
/// are not finite are black. `scale` > 0.
std::vector<Rgb> colours_of_errors(const std::vector<double>& errors, double scale);

}  // namespace relief
