#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "relief/scan/result.h"

namespace relief {

/// How the pixels of a bitmap are stored; numbers of the file.
enum class BmpCompression : std::uint32_t { kStored = 0, kRle8 = 1, kRle4 = 2, kMasks = 3 };

/// The headers of a Windows or OS/2 bitmap.
struct BmpHeader {
  std::size_t pixels_at = 0;           ///< [bytes]
  std::size_t header_bytes = 0;        ///< Of the second header, which tells the version.
  std::int64_t width = 0, height = 0;  ///< A negative height: from the top down.
  std::uint32_t bits = 0;              ///< Of a pixel.
  BmpCompression compression = BmpCompression::kStored;
  std::uint32_t palette_size = 0;        ///< Zero: as many colours as the bits can tell.
  std::array<std::uint32_t, 3> masks{};  ///< The bits of red, green and blue: 16 and 32 bits.

  bool packed() const {
    return compression == BmpCompression::kRle8 || compression == BmpCompression::kRle4;
  }
  std::size_t rows() const { return static_cast<std::size_t>(height < 0 ? -height : height); }
  std::size_t columns() const { return static_cast<std::size_t>(width < 0 ? 0 : width); }
  /// The place in the file of the row that is the v-th from the top.
  std::size_t stored_row(std::size_t v) const { return height < 0 ? v : rows() - 1 - v; }
  std::size_t palette_at() const;
  std::size_t colour_bytes() const;  ///< Of a colour of the palette.
  std::size_t colours() const;       ///< Of the palette; zero for pixels that are colours.
  /// Rows are filled up to four bytes.
  std::size_t row_bytes() const { return (columns() * bits + 31) / 32 * 4; }
};

/// Nothing where the file ends within its headers, or is no bitmap.
std::optional<BmpHeader> read_bmp_header(std::string_view content);

/// An error (kBadInput) that tells the remedy unless the pixels are of a kind that is read, and the
/// palette and, if they are not packed, all pixels are in the file (see check_image_header()).
Result<void> check_bmp_header(const BmpHeader& header, std::size_t file_bytes,
                              const std::filesystem::path& path);

}  // namespace relief
