#include "scan/io/images/codecs/colours/image_palette.h"

#include <algorithm>
#include <string>

#include "scan/io/files/io_error.h"

namespace relief {

bool ImagePalette::is_grey() const {
  return std::all_of(colours.begin(), colours.end(), [](const Colour& colour) {
    return colour[0] == colour[1] && colour[1] == colour[2];
  });
}

Result<Image> resolve_palette(const PalettePixels& pixels, const ImagePalette& palette,
                              const std::filesystem::path& path) {
  const std::size_t channels = palette.is_grey() ? 1 : 3;
  Image image(static_cast<int>(pixels.width), static_cast<int>(pixels.height),
              static_cast<int>(channels), 255.0);
  float* sample = image.samples.data();
  for (std::size_t i = 0; i < pixels.places.size(); ++i) {
    const std::size_t place = pixels.places[i];
    if (place < palette.first || place - palette.first >= palette.colours.size())
      return bad_input(path, "damaged: pixel " + std::to_string(i) + " has colour " +
                                 std::to_string(place) + ", which its palette does not have");
    const Colour& colour = palette.colours[place - palette.first];
    for (std::size_t c = 0; c < channels; ++c) *sample++ = colour[c];
  }
  return image;
}

}  // namespace relief
