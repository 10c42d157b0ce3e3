#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "relief/scan/result.h"
#include "scan/io/images/image_io.h"

struct tiff;  // Of libtiff.

namespace relief {

/// How a TIFF file stores its pixels: the values of its tags.
struct TiffLayout {
  std::uint32_t width = 0, height = 0;
  std::uint16_t samples_per_pixel = 1, bits = 1, format = 1;
  std::uint16_t planar = 1;
  std::uint16_t orientation = 1, photometric = 1;
  std::uint16_t compression = 1;

  std::size_t sample_bytes() const { return bits / 8; }
  /// Whether each channel has blocks of its own.
  bool separate() const { return planar == 2 && samples_per_pixel > 1; }
  int channels() const { return samples_per_pixel >= 3 ? 3 : 1; }  ///< That are read.
};

TiffLayout read_tiff_layout(tiff* file);

/// An error (kBadInput) that tells the remedy unless samples are of a type read here, stand for
/// grey or RGB, and fit into a file of `file_bytes` (see check_image_header()).
Result<void> check_tiff_layout(const TiffLayout& layout, std::size_t file_bytes,
                               const std::filesystem::path& path);

/// An image as stored, by the tag Orientation (1 to 8), with its top in the first row and its left
/// side in the first column.
Image upright(Image stored, std::uint16_t orientation);

}  // namespace relief
