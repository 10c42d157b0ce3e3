#include "scan/rendering/pictures/colour_maps.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scan/evaluation/base/error_colours.h"

namespace relief::rendering {

namespace {

constexpr int kSteps = 256;  // Values of a byte.

// Every thirty-second colour of viridis.
constexpr std::array<Colour, 9> kViridis{{{68, 1, 84},
                                          {71, 44, 122},
                                          {59, 81, 139},
                                          {44, 113, 142},
                                          {33, 144, 141},
                                          {39, 173, 129},
                                          {92, 200, 99},
                                          {170, 220, 50},
                                          {253, 231, 37}}};

}  // namespace

ColourMap sequential_map() {
  ColourMap map(kSteps);
  for (int i = 0; i < kSteps; ++i) {
    const double place = (kViridis.size() - 1.0) * i / (kSteps - 1);
    const auto before = std::min(static_cast<std::size_t>(place), kViridis.size() - 2);
    const double share = place - static_cast<double>(before);
    for (std::size_t k = 0; k < 3; ++k)
      map[static_cast<std::size_t>(i)][k] = static_cast<std::uint8_t>(
          std::lround((1.0 - share) * kViridis[before][k] + share * kViridis[before + 1][k]));
  }
  return map;
}

ColourMap diverging_map() {
  std::vector<double> places(kSteps);
  for (int i = 0; i < kSteps; ++i)
    places[static_cast<std::size_t>(i)] = 2.0 * i / (kSteps - 1) - 1.0;
  return evaluation::colours_of_errors(places, 1.0);
}

Colour colour_at(const ColourMap& map, double value, double low, double high) {
  const double share = high > low ? (value - low) / (high - low) : 0.0;
  const double last = static_cast<double>(map.size() - 1);
  return map[static_cast<std::size_t>(std::lround(std::clamp(share, 0.0, 1.0) * last))];
}

}  // namespace relief::rendering
