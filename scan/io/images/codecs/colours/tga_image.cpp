// Truevision images. The comments and tables of version 2 are not used.
#include <cstdint>
#include <string>

#include "relief/scan/grid.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/colours/image_palette.h"
#include "scan/io/images/codecs/little_endian.h"
#include "scan/io/images/codecs/tiff_layout.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

constexpr std::size_t kTgaHeaderBytes = 18;
// Five bytes make a run of 128 pixels of four bytes.
constexpr std::size_t kTgaRle = 103;

enum TgaKind : std::uint8_t { kTgaPalette = 1, kTgaColour = 2, kTgaGrey = 3 };

struct TgaHeader {
  std::uint8_t comment_bytes = 0, has_palette = 0, type = 0;
  std::uint16_t first_colour = 0, colours = 0;
  std::uint8_t colour_bits = 0;
  std::uint16_t width = 0, height = 0;
  std::uint8_t bits = 0, attributes = 0;

  bool packed() const { return type >= 8; }
  int kind() const { return type & 7; }
  int alpha_bits() const { return attributes & 15; }
  std::size_t palette_at() const { return kTgaHeaderBytes + comment_bytes; }
  std::size_t colour_bytes() const { return (colour_bits + 7u) / 8; }
  std::size_t pixels_at() const {
    return palette_at() + (has_palette ? colours * colour_bytes() : 0);
  }
  std::size_t pixel_bytes() const { return (bits + 7u) / 8; }
  std::size_t pixels() const { return std::size_t{width} * height; }
  bool from_right() const { return (attributes & 0x10) != 0; }
  bool from_top() const { return (attributes & 0x20) != 0; }
  // As upright() takes it.
  std::uint16_t orientation() const {
    if (from_top()) return from_right() ? 2 : 1;
    return from_right() ? 3 : 4;
  }
};

std::uint8_t tga_byte(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint8_t>(bytes[at]);
}

TgaHeader read_tga_header(std::string_view content) {
  TgaHeader header;
  header.comment_bytes = tga_byte(content, 0);
  header.has_palette = tga_byte(content, 1);
  header.type = tga_byte(content, 2);
  header.first_colour = little_endian_at<std::uint16_t>(content, 3);
  header.colours = little_endian_at<std::uint16_t>(content, 5);
  header.colour_bits = tga_byte(content, 7);
  header.width = little_endian_at<std::uint16_t>(content, 12);
  header.height = little_endian_at<std::uint16_t>(content, 14);
  header.bits = tga_byte(content, 16);
  header.attributes = tga_byte(content, 17);
  return header;
}

bool is_readable(const TgaHeader& header) {
  if (header.has_palette > 1 || (header.attributes & 0xc0) != 0) return false;  // Interleaved.
  if (header.type != header.kind() && header.type != header.kind() + 8) return false;
  const auto is_colour = [](int bits) {
    return bits == 15 || bits == 16 || bits == 24 || bits == 32;
  };
  switch (header.kind()) {
    case kTgaPalette:
      return header.has_palette == 1 && header.bits == 8 && is_colour(header.colour_bits);
    case kTgaColour:
      return is_colour(header.bits);
    case kTgaGrey:
      return header.bits == 8 || (header.bits == 16 && header.alpha_bits() == 8);
    default:
      return false;
  }
}

Result<void> check_tga(const TgaHeader& header, std::size_t file_bytes,
                       const std::filesystem::path& path) {
  if (!is_readable(header))
    return bad_input(path, "not a TGA file, or one of an unknown kind: type " +
                               std::to_string(header.type) + " with " +
                               std::to_string(header.bits) +
                               " bits a pixel; save it as grey or RGB of 8 bits");
  const std::size_t channels = header.kind() == kTgaGrey ? 1 : 3;
  const ImageHeader image{header.width, header.height, 8 * header.pixel_bytes(), channels,
                          header.packed() ? kTgaRle : kUncompressed};
  if (auto checked = check_image_header(image, file_bytes, path); !checked) return checked;
  const std::size_t stored = header.packed() ? 1 : header.pixels() * header.pixel_bytes();
  if (header.pixels_at() + stored > file_bytes)
    return bad_input(path, "truncated: at least " + std::to_string(header.pixels_at() + stored) +
                               " bytes expected, " + std::to_string(file_bytes) +
                               " found; copy it again");
  return {};
}

// Red, green and blue of a colour of 15 to 32 bits; blue comes first.
Colour tga_colour(std::string_view bytes, std::size_t colour_bytes) {
  if (colour_bytes > 2) return {tga_byte(bytes, 2), tga_byte(bytes, 1), tga_byte(bytes, 0)};
  const std::uint32_t value = little_endian_at<std::uint16_t>(bytes, 0);
  return {scaled_to_byte(value >> 10 & 31, 31), scaled_to_byte(value >> 5 & 31, 31),
          scaled_to_byte(value & 31, 31)};
}

ImagePalette read_tga_palette(const TgaHeader& header, std::string_view content) {
  ImagePalette palette{header.first_colour, {}};
  for (std::size_t i = 0; i < header.colours; ++i)
    palette.colours.push_back(tga_colour(
        content.substr(header.palette_at() + i * header.colour_bytes()), header.colour_bytes()));
  return palette;
}

// Packets are a byte and pixels: a count, and whether one pixel repeats. They may cross lines.
Result<std::string> unpack_tga(const TgaHeader& header, std::string_view rest,
                               const std::filesystem::path& path) {
  const std::size_t whole = header.pixels() * header.pixel_bytes();
  std::string bytes;
  bytes.reserve(whole);
  while (bytes.size() < whole) {
    const std::uint8_t head = rest.empty() ? 0 : tga_byte(rest, 0);
    const bool repeats = (head & 0x80) != 0;
    const std::size_t count = (head & 0x7f) + std::size_t{1};
    const std::size_t stored = (repeats ? 1 : count) * header.pixel_bytes();
    if (rest.size() < 1 + stored)
      return bad_input(path, "truncated: its runs end after " +
                                 std::to_string(bytes.size() / header.pixel_bytes()) + " of " +
                                 std::to_string(header.pixels()) + " pixels; copy it again");
    if (count * header.pixel_bytes() > whole - bytes.size())
      return bad_input(path, "damaged TGA: its runs go on after its last pixel");
    for (std::size_t i = 0; i < (repeats ? count : 1); ++i) bytes.append(rest.substr(1, stored));
    rest.remove_prefix(1 + stored);
  }
  return bytes;
}

Result<Image> read_tga_pixels(const TgaHeader& header, std::string_view bytes,
                              std::string_view content, const std::filesystem::path& path) {
  if (header.kind() == kTgaPalette) {
    PalettePixels pixels{header.width, header.height, {}};
    pixels.places.assign(bytes.begin(),
                         bytes.begin() + static_cast<std::ptrdiff_t>(header.pixels()));
    return resolve_palette(pixels, read_tga_palette(header, content), path);
  }
  Image image(header.width, header.height, header.kind() == kTgaGrey ? 1 : 3, 255.0);
  float* sample = image.samples.data();
  for (std::size_t i = 0; i < header.pixels(); ++i) {
    const auto pixel = bytes.substr(i * header.pixel_bytes());
    if (header.kind() == kTgaGrey) {
      *sample++ = tga_byte(pixel, 0);  // Alpha may follow.
      continue;
    }
    for (const std::uint8_t value : tga_colour(pixel, header.pixel_bytes())) *sample++ = value;
  }
  return image;
}

}  // namespace

Result<Image> decode_tga(std::string_view content, const std::filesystem::path& path) {
  if (content.size() < kTgaHeaderBytes)
    return bad_input(path, "not a TGA file: it has " + std::to_string(content.size()) +
                               " bytes, less than a header");
  const TgaHeader header = read_tga_header(content);
  if (auto checked = check_tga(header, content.size(), path); !checked) return checked.error();
  std::string_view bytes = content.substr(header.pixels_at());
  std::string unpacked;
  if (header.packed()) {
    auto result = unpack_tga(header, bytes, path);
    if (!result) return result.error();
    unpacked = *std::move(result);
    bytes = unpacked;
  }
  auto image = read_tga_pixels(header, bytes, content, path);
  if (!image) return image;
  return upright(*std::move(image), header.orientation());
}

}  // namespace relief
