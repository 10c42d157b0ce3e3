#include "scan/evaluation/base/error_colours.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace relief::evaluation {

namespace {

// The ends and the middle of the diverging map of Moreland (2009).
constexpr std::array<double, 3> kLow{59, 76, 192}, kMiddle{221, 221, 221}, kHigh{180, 4, 38};

Colour colour_of(double share) {
  const auto& end = share < 0.0 ? kLow : kHigh;
  Colour colour;
  for (std::size_t k = 0; k < 3; ++k)
    colour[k] = static_cast<std::uint8_t>(
        std::lround(kMiddle[k] + std::abs(share) * (end[k] - kMiddle[k])));
  return colour;
}

}  // namespace

std::vector<Colour> colours_of_errors(const std::vector<double>& errors, double scale) {
  assert(scale > 0.0);
  std::vector<Colour> colours;
  colours.reserve(errors.size());
  for (const double error : errors)
    colours.push_back(std::isfinite(error) ? colour_of(std::clamp(error / scale, -1.0, 1.0))
                                           : Colour{0, 0, 0});
  return colours;
}

}  // namespace relief::evaluation
