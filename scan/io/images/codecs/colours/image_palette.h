#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "relief/scan/grid.h"
#include "relief/scan/result.h"
#include "scan/io/images/image_io.h"

namespace relief {

/// The colours that the pixels of a file name by their places.
struct ImagePalette {
  std::size_t first = 0;  ///< The place of the first colour.
  std::vector<Colour> colours;

  bool is_grey() const;
};

/// Pixels that are places in a palette, row by row.
struct PalettePixels {
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> places;
};

/// An image of 8 bits: of one channel if all colours of the palette are greys, else of three.
/// kBadInput, naming the pixel, for a place that the palette does not have.
Result<Image> resolve_palette(const PalettePixels& pixels, const ImagePalette& palette,
                              const std::filesystem::path& path);

/// A number of 0 to `largest` as one of 0 to 255.
inline std::uint8_t scaled_to_byte(std::uint32_t value, std::uint32_t largest) {
  return static_cast<std::uint8_t>((std::uint64_t{value} * 255 + largest / 2) / largest);
}

}  // namespace relief
