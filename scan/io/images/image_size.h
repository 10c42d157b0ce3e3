#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace relief {

struct ImageSize {
  int width = 0, height = 0;  ///< [pixels]
  bool operator==(const ImageSize&) const = default;
};

/// The size that the header of a PNG, JPEG, PNM (P2, P3, P5, P6), BMP, TGA, HDR, WebP, NPY or
/// COLMAP array says, upright. Nothing is decoded. Nothing for other formats and for damaged
/// headers.
std::optional<ImageSize> image_size(const std::filesystem::path& path);

/// Whether the header of a file is that of a PNG with one channel of 16 bits, as of depth maps.
bool is_grey_16_bit_png(const std::filesystem::path& path);

/// Whether a file name ends like an image that can hold depths.
bool has_depth_image_ending(const std::filesystem::path& path);

/// Whether a file name ends like a photograph.
bool has_photograph_ending(const std::filesystem::path& path);

}  // namespace relief
