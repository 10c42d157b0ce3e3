#pragma once

#include <array>
#include <cstdint>

namespace relief {

/// Red, green, blue as they stand in files, commonly sRGB.
using Colour = std::array<std::uint8_t, 3>;

}  // namespace relief
