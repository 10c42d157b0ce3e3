#pragma once

#include <array>
#include <cstdint>

#include "relief/scan/grid.h"

namespace relief::rendering {

/// Red, green, blue as sRGB, and opacity (0: transparent, 255: opaque); colours are not multiplied
/// by the opacity.
using Rgba = std::array<std::uint8_t, 4>;

/// A picture, its first row at the top.
using Picture = Grid<Rgba>;

/// What is behind the surface.
enum class Background { kWhite, kTransparent };

inline constexpr Rgba kOpaqueWhite{255, 255, 255, 255};
inline constexpr Rgba kNothing{255, 255, 255, 0};

inline Rgba background_colour(Background background) {
  return background == Background::kWhite ? kOpaqueWhite : kNothing;
}

}  // namespace relief::rendering
