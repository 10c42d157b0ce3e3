// Windows and OS/2 bitmaps.
//
// Why BMP, TGA and HDR have decoders here: the library of the distribution for them, OpenImageIO,
// overruns buffers on some BMP and TGA files and takes 0.25 s to load (docs/results.md).
#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/colours/bmp_header.h"
#include "scan/io/images/codecs/colours/image_palette.h"
#include "scan/io/images/codecs/little_endian.h"
#include "scan/io/images/image_io.h"

namespace relief {

namespace {

std::uint8_t bmp_byte(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint8_t>(bytes[at]);
}

// Blue comes first.
ImagePalette read_bmp_palette(const BmpHeader& header, std::string_view content) {
  ImagePalette palette;
  for (std::size_t i = 0; i < header.colours(); ++i) {
    const std::size_t at = header.palette_at() + i * header.colour_bytes();
    palette.colours.push_back(
        {bmp_byte(content, at + 2), bmp_byte(content, at + 1), bmp_byte(content, at)});
  }
  return palette;
}

// One, four or eight bits of a row; the leftmost pixel has the upper bits of its byte.
std::uint8_t packed_place(std::string_view row, std::size_t u, std::uint32_t bits) {
  const std::size_t per_byte = 8 / bits;
  const auto shift = static_cast<unsigned>(8 - bits * (u % per_byte + 1));
  return static_cast<std::uint8_t>(bmp_byte(row, u / per_byte) >> shift & ((1u << bits) - 1));
}

void read_stored_places(const BmpHeader& header, std::string_view content, PalettePixels& pixels) {
  auto place = pixels.places.begin();
  for (std::size_t v = 0; v < pixels.height; ++v) {
    const auto row = content.substr(header.pixels_at + header.stored_row(v) * header.row_bytes());
    for (std::size_t u = 0; u < pixels.width; ++u) *place++ = packed_place(row, u, header.bits);
  }
}

// Unpacks runs of a bitmap from the bottom up. Pairs of bytes: a count and the places that repeat,
// or zero and a code: the end of a line, the end of all, a jump, or a count of places that follow.
class BmpRuns {
 public:
  BmpRuns(std::string_view bytes, std::uint32_t bits, PalettePixels& pixels)
      : rest_(bytes), bits_(bits), pixels_(pixels) {}

  // Empty, or what is wrong.
  std::string unpack() {
    while (rest_.size() >= 2) {
      const std::size_t count = bmp_byte(rest_, 0), code = bmp_byte(rest_, 1);
      rest_.remove_prefix(count > 0 ? 1 : 2);
      if (count > 0) {
        if (!fits(count)) return kOutside;
        const auto pattern = rest_.substr(0, 1);
        for (std::size_t i = 0; i < count; ++i) put(pattern, i % (8 / bits_));
        rest_.remove_prefix(1);
      } else if (code == kEndOfLine) {
        if (!end_line()) return kLeftOut;
      } else if (code == kEndOfAll) {
        if (column_ > 0 && !end_line()) return kLeftOut;
        return row_ == pixels_.height ? "" : kLeftOut;
      } else if (code == kJump) {
        return kLeftOut;
      } else {
        const std::size_t bytes = (code * bits_ + 15) / 16 * 2;  // Filled up to two.
        if (bytes > rest_.size()) break;
        if (!fits(code)) return kOutside;
        const auto places = rest_.substr(0, bytes);
        for (std::size_t i = 0; i < code; ++i) put(places, i);
        rest_.remove_prefix(bytes);
      }
    }
    return "truncated: the file ends before its runs; copy it again";
  }

 private:
  static constexpr std::size_t kEndOfLine = 0, kEndOfAll = 1, kJump = 2;
  static constexpr const char* kOutside = "damaged BMP: a run goes beyond its line";
  static constexpr const char* kLeftOut =
      "damaged or unsupported BMP: its runs leave pixels out; save it uncompressed";

  bool fits(std::size_t count) const {
    return row_ < pixels_.height && count <= pixels_.width - column_;
  }
  void put(std::string_view bytes, std::size_t i) {
    pixels_.places[(pixels_.height - 1 - row_) * pixels_.width + column_++] =
        packed_place(bytes, i, bits_);
  }
  bool end_line() {
    if (row_ == pixels_.height || column_ != pixels_.width) return false;
    ++row_;
    column_ = 0;
    return true;
  }

  std::string_view rest_;
  std::uint32_t bits_;
  PalettePixels& pixels_;
  std::size_t column_ = 0, row_ = 0;  // From the bottom up.
};

Result<Image> read_bmp_places(const BmpHeader& header, std::string_view content,
                              const std::filesystem::path& path) {
  PalettePixels pixels{header.columns(), header.rows(), {}};
  pixels.places.resize(pixels.width * pixels.height);
  if (header.packed()) {
    const auto why = BmpRuns(content.substr(header.pixels_at), header.bits, pixels).unpack();
    if (!why.empty()) return bad_input(path, why);
  } else {
    read_stored_places(header, content, pixels);
  }
  return resolve_palette(pixels, read_bmp_palette(header, content), path);
}

float masked_sample(std::uint32_t pixel, std::uint32_t mask) {
  const int shift = std::countr_zero(mask);
  return scaled_to_byte((pixel & mask) >> shift, mask >> shift);
}

Image read_bmp_colours(const BmpHeader& header, std::string_view content) {
  Image image(static_cast<int>(header.columns()), static_cast<int>(header.rows()), 3, 255.0);
  float* sample = image.samples.data();
  for (std::size_t v = 0; v < header.rows(); ++v) {
    std::size_t at = header.pixels_at + header.stored_row(v) * header.row_bytes();
    for (std::size_t u = 0; u < header.columns(); ++u, at += header.bits / 8) {
      if (header.bits == 24) {
        for (std::size_t c = 3; c-- > 0;) *sample++ = bmp_byte(content, at + c);
        continue;
      }
      const std::uint32_t pixel = header.bits == 16 ? little_endian_at<std::uint16_t>(content, at)
                                                    : little_endian_at<std::uint32_t>(content, at);
      for (const std::uint32_t mask : header.masks) *sample++ = masked_sample(pixel, mask);
    }
  }
  return image;
}

}  // namespace

Result<Image> decode_bmp(std::string_view content, const std::filesystem::path& path) {
  const auto header = read_bmp_header(content);
  if (!header)
    return bad_input(path, "not a BMP file, or one that ends within its header (" +
                               std::to_string(content.size()) + " bytes)");
  if (auto checked = check_bmp_header(*header, content.size(), path); !checked)
    return checked.error();
  if (header->bits <= 8) return read_bmp_places(*header, content, path);
  return read_bmp_colours(*header, content);
}

}  // namespace relief
