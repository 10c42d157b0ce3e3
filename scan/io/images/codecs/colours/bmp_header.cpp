#include "scan/io/images/codecs/colours/bmp_header.h"

#include <algorithm>
#include <bit>
#include <string>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/little_endian.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

constexpr std::size_t kBmpFileHeader = 14;
constexpr std::size_t kOldBmpHeader = 12;  // Of OS/2: sizes of 16 bits, colours of 3 bytes.
constexpr std::size_t kBmpMasksAt = 54, kBmpMasksEnd = 66;
// Two bytes make a run of 255 pixels.
constexpr std::size_t kBmpRle = 128;

bool is_known_bmp_header(std::size_t bytes) {
  constexpr std::array<std::size_t, 6> kKnown{kOldBmpHeader, 40, 52, 56, 108, 124};
  return std::find(kKnown.begin(), kKnown.end(), bytes) != kKnown.end();
}

// False: the file ends before them.
bool read_bmp_masks(std::string_view content, BmpHeader& header) {
  if (header.bits == 16) header.masks = {0x7c00, 0x3e0, 0x1f};
  if (header.bits == 32) header.masks = {0xff0000, 0xff00, 0xff};
  if (header.compression != BmpCompression::kMasks) return true;
  if (content.size() < kBmpMasksEnd) return false;
  for (std::size_t c = 0; c < 3; ++c)
    header.masks[c] = little_endian_at<std::uint32_t>(content, kBmpMasksAt + 4 * c);
  return true;
}

// Whether every colour has bits side by side, all within a pixel.
bool are_readable_masks(const BmpHeader& header) {
  return std::all_of(header.masks.begin(), header.masks.end(), [&](std::uint32_t mask) {
    if (mask == 0 || (header.bits < 32 && mask >> header.bits != 0)) return false;
    return std::countl_zero(mask) + std::popcount(mask) + std::countr_zero(mask) == 32;
  });
}

// Why the pixels cannot be read; empty: they can.
std::string unsupported_bmp(const BmpHeader& header) {
  constexpr std::array<std::uint32_t, 6> kBits{1, 4, 8, 16, 24, 32};
  const std::string of_bits = " of " + std::to_string(header.bits) + " bits a pixel";
  const std::string remedy = "; save it uncompressed with 8 or 24 bits";
  switch (header.compression) {
    case BmpCompression::kStored:
      if (std::find(kBits.begin(), kBits.end(), header.bits) != kBits.end()) return {};
      return "pixels" + of_bits + remedy;
    case BmpCompression::kMasks:
      if ((header.bits == 16 || header.bits == 32) && are_readable_masks(header)) return {};
      return "unusual masks" + of_bits + remedy;
    case BmpCompression::kRle8:
    case BmpCompression::kRle4:
      if (header.bits == (header.compression == BmpCompression::kRle8 ? 8 : 4) && header.height > 0)
        return {};
      return "run-length encoding" + of_bits + " or from the top down" + remedy;
  }
  return "compression " + std::to_string(static_cast<std::uint32_t>(header.compression)) + remedy;
}

}  // namespace

std::size_t BmpHeader::palette_at() const { return kBmpFileHeader + header_bytes; }

std::size_t BmpHeader::colour_bytes() const { return header_bytes == kOldBmpHeader ? 3 : 4; }

std::size_t BmpHeader::colours() const {
  if (bits > 8) return 0;
  return palette_size > 0 ? palette_size : std::size_t{1} << bits;
}

std::optional<BmpHeader> read_bmp_header(std::string_view content) {
  if (content.size() < kBmpFileHeader + kOldBmpHeader || !content.starts_with("BM"))
    return std::nullopt;
  BmpHeader header;
  header.pixels_at = little_endian_at<std::uint32_t>(content, 10);
  header.header_bytes = little_endian_at<std::uint32_t>(content, 14);
  if (!is_known_bmp_header(header.header_bytes) || content.size() < header.palette_at())
    return std::nullopt;
  if (header.header_bytes == kOldBmpHeader) {
    header.width = little_endian_at<std::uint16_t>(content, 18);
    header.height = little_endian_at<std::uint16_t>(content, 20);
    header.bits = little_endian_at<std::uint16_t>(content, 24);
  } else {
    header.width = little_endian_at<std::int32_t>(content, 18);
    header.height = little_endian_at<std::int32_t>(content, 22);
    header.bits = little_endian_at<std::uint16_t>(content, 28);
    header.compression = BmpCompression{little_endian_at<std::uint32_t>(content, 30)};
    header.palette_size = little_endian_at<std::uint32_t>(content, 46);
  }
  if (!read_bmp_masks(content, header)) return std::nullopt;
  return header;
}

Result<void> check_bmp_header(const BmpHeader& header, std::size_t file_bytes,
                              const std::filesystem::path& path) {
  if (const auto why = unsupported_bmp(header); !why.empty())
    return bad_input(path, "unsupported BMP: " + why);
  const ImageHeader image{header.columns(), header.rows(), header.bits, 3,
                          header.packed() ? kBmpRle : kUncompressed};
  if (auto checked = check_image_header(image, file_bytes, path); !checked) return checked;
  const std::size_t palette_end = header.palette_at() + header.colours() * header.colour_bytes();
  if (header.bits <= 8 && (header.colours() > std::size_t{1} << header.bits ||
                           palette_end > file_bytes || palette_end > header.pixels_at))
    return bad_input(path, "damaged BMP: its palette of " + std::to_string(header.colours()) +
                               " colours does not fit between its header and its pixels");
  if (header.pixels_at < header.palette_at())
    return bad_input(path, "damaged BMP: its pixels begin at byte " +
                               std::to_string(header.pixels_at) + ", within its header");
  const std::size_t end =
      header.pixels_at + (header.packed() ? 0 : header.row_bytes() * header.rows());
  if (end > file_bytes)
    return bad_input(path, "truncated: a BMP of this size has " + std::to_string(end) +
                               " bytes, this file has " + std::to_string(file_bytes) +
                               "; copy it again");
  return {};
}

}  // namespace relief
