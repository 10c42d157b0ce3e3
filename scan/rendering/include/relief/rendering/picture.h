#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

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

/// What the colours of a picture mean: a bar from `low` to `high`, or single colours with a word.
struct Legend {
  std::string title;
  double low = 0.0, high = 0.0;  ///< Of the ends of the bar [unit of the title].
  std::vector<Colour> bar;       ///< From low to high; empty: no bar.

  struct Entry {
    Colour colour;
    std::string text;
  };
  std::vector<Entry> entries;
};

/// In words, as `depth [mm]: 10.2 to 33.5`.
std::string describe(const Legend& legend);

/// The picture with its legend in a strip below it. A legend that is wider gets more background on
/// both sides of the picture.
Picture with_legend(const Picture& picture, const Legend& legend, Background background);

/// The picture with a line of text above it, widened likewise.
Picture with_caption(const Picture& picture, const std::string& caption, Background background);

/// Pictures side by side, row by row. Columns are as wide as their widest picture, rows as high as
/// their highest. `columns` >= 1.
Picture contact_sheet(const std::vector<Picture>& pictures, int columns, Background background);

}  // namespace relief::rendering
