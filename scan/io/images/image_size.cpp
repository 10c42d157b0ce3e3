#include "scan/io/images/image_size.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <initializer_list>
#include <string>
#include <string_view>

#include "scan/io/files/file_ending.h"
#include "scan/io/images/codecs/floats/hdr_header.h"
#include "scan/io/images/codecs/floats/npy_header.h"
#include "scan/io/images/codecs/little_endian.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

// Headers of JPEG files hold thumbnails and profiles before the size.
constexpr std::size_t kHeaderBytes = 1 << 20;

unsigned byte_at(std::string_view bytes, std::size_t i) {
  return static_cast<unsigned char>(bytes[i]);
}

unsigned big_endian(std::string_view bytes, std::size_t offset, std::size_t count) {
  unsigned value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | byte_at(bytes, offset + i);
  return value;
}

std::optional<ImageSize> checked_size(unsigned width, unsigned height) {
  if (width == 0 || height == 0 || width > kMaxImageSide || height > kMaxImageSide)
    return std::nullopt;
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

// The first chunk of a PNG, IHDR, begins with both sizes.
std::optional<ImageSize> png_size(std::string_view bytes) {
  if (bytes.size() < 24) return std::nullopt;
  return checked_size(big_endian(bytes, 16, 4), big_endian(bytes, 20, 4));
}

// Segments are a marker and a length; a frame header (SOF) holds height and width.
std::optional<ImageSize> jpeg_size(std::string_view bytes) {
  for (std::size_t i = 2; i + 9 <= bytes.size();) {
    if (byte_at(bytes, i) != 0xff) return std::nullopt;
    const unsigned marker = byte_at(bytes, i + 1);
    if (marker == 0xff) {  // A byte of padding.
      ++i;
      continue;
    }
    const bool frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return checked_size(big_endian(bytes, i + 7, 2), big_endian(bytes, i + 5, 2));
    i += 2 + std::max(2u, big_endian(bytes, i + 2, 2));
  }
  return std::nullopt;
}

// A number of a text header; white space and comments before it are skipped.
bool take_header_number(std::string_view& rest, unsigned& value) {
  for (;;) {
    while (!rest.empty() && std::isspace(static_cast<unsigned char>(rest.front())))
      rest.remove_prefix(1);
    if (rest.empty() || rest.front() != '#') break;
    rest.remove_prefix(std::min(rest.find('\n'), rest.size()));
  }
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return error == std::errc();
}

std::optional<ImageSize> pnm_size(std::string_view bytes) {
  unsigned width = 0, height = 0;
  bytes.remove_prefix(2);
  if (!take_header_number(bytes, width) || !take_header_number(bytes, height)) return std::nullopt;
  return checked_size(width, height);
}

std::optional<ImageSize> array_size(std::string_view bytes) {
  unsigned width = 0, height = 0;
  if (!take_header_number(bytes, width) || !bytes.starts_with('&')) return std::nullopt;
  bytes.remove_prefix(1);
  if (!take_header_number(bytes, height) || !bytes.starts_with('&')) return std::nullopt;
  return checked_size(width, height);
}

std::optional<ImageSize> bmp_size(std::string_view bytes) {
  constexpr std::uint32_t kOldHeader = 12;
  if (bytes.size() < 26) return std::nullopt;
  if (little_endian_at<std::uint32_t>(bytes, 14) == kOldHeader)
    return checked_size(little_endian_at<std::uint16_t>(bytes, 18),
                        little_endian_at<std::uint16_t>(bytes, 20));
  const auto height = little_endian_at<std::int32_t>(bytes, 22);  // Negative: from the top down.
  return checked_size(
      little_endian_at<std::uint32_t>(bytes, 18),
      height < 0 ? 0u - static_cast<std::uint32_t>(height) : static_cast<std::uint32_t>(height));
}

std::optional<ImageSize> tga_size(std::string_view bytes) {
  if (bytes.size() < 18) return std::nullopt;
  return checked_size(little_endian_at<std::uint16_t>(bytes, 12),
                      little_endian_at<std::uint16_t>(bytes, 14));
}

// The first part of the file is the header of an extended one, or pixels of either kind.
std::optional<ImageSize> webp_size(std::string_view bytes) {
  constexpr unsigned kSideBits = 0x3fff;
  if (bytes.size() < 30) return std::nullopt;
  const std::string_view part = bytes.substr(12, 4);
  if (part == "VP8X")
    return checked_size((little_endian_at<std::uint32_t>(bytes, 24) & 0xffffff) + 1,
                        (little_endian_at<std::uint32_t>(bytes, 26) >> 8) + 1);
  if (part == "VP8L") {
    const auto bits = little_endian_at<std::uint32_t>(bytes, 21);
    return checked_size((bits & kSideBits) + 1, (bits >> 14 & kSideBits) + 1);
  }
  return checked_size(little_endian_at<std::uint16_t>(bytes, 26) & kSideBits,
                      little_endian_at<std::uint16_t>(bytes, 28) & kSideBits);
}

std::optional<ImageSize> hdr_size(std::string_view bytes) {
  const auto header = read_hdr_header(bytes);
  if (!header || header->width > kMaxImageSide || header->height > kMaxImageSide)
    return std::nullopt;
  const auto width = static_cast<unsigned>(header->width);
  const auto height = static_cast<unsigned>(header->height);
  return header->lines_are_columns() ? checked_size(height, width) : checked_size(width, height);
}

std::optional<ImageSize> npy_size(std::string_view bytes) {
  const auto header = read_npy_header(bytes, "");
  if (!header) return std::nullopt;
  const std::vector<std::size_t> shape = image_shape(*header);
  if (shape.size() < 2 || shape[0] > kMaxImageSide || shape[1] > kMaxImageSide) return std::nullopt;
  return checked_size(static_cast<unsigned>(shape[1]), static_cast<unsigned>(shape[0]));
}

// Corners of the pixels that are there, both inclusive.
std::optional<ImageSize> exr_size(std::string_view bytes) {
  constexpr std::string_view kDataWindow("dataWindow\0box2i\0\x10\0\0\0", 21);
  const std::size_t place = bytes.find(kDataWindow);
  if (place == std::string_view::npos || bytes.size() < place + kDataWindow.size() + 16)
    return std::nullopt;
  const auto corner = [&](std::size_t k) {
    return std::int64_t{little_endian_at<std::int32_t>(bytes, place + kDataWindow.size() + 4 * k)};
  };
  const std::int64_t width = corner(2) - corner(0) + 1, height = corner(3) - corner(1) + 1;
  if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide)
    return std::nullopt;
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

std::string read_head(std::ifstream& file, std::size_t bytes) {
  std::string head(bytes, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  return head;
}

bool ends_like(const std::filesystem::path& path, std::initializer_list<const char*> endings) {
  const std::string ending = lower_ending(path);
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

}  // namespace

std::optional<ImageSize> image_size(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string head = read_head(file, 64);
  const auto more = [&] { return head + read_head(file, kHeaderBytes); };
  if (head.starts_with("\x89PNG")) return png_size(head);
  if (head.starts_with("\xff\xd8")) return jpeg_size(more());
  if (head.starts_with("BM")) return bmp_size(head);
  if (head.starts_with("RIFF") && head.substr(8, 4) == "WEBP") return webp_size(head);
  if (head.starts_with("\x76\x2f\x31\x01")) return exr_size(more());
  if (head.starts_with("#?")) return hdr_size(more());
  if (head.starts_with("\x93NUMPY")) return npy_size(more());
  if (head.size() > 2 && head[0] == 'P' && std::string_view("2356Ff").find(head[1]) < 6)
    return pnm_size(head);
  return lower_ending(path) == ".tga" ? tga_size(head) : array_size(head);  // No mark of its own.
}

bool is_grey_16_bit_png(const std::filesystem::path& path) {
  constexpr std::size_t kHeader = 26;  // The signature, the sizes, bits a sample, the colour type.
  std::string bytes(kHeader, '\0');
  std::ifstream file(path, std::ios::binary);
  return file.read(bytes.data(), kHeader) && bytes.starts_with("\x89PNG") &&
         byte_at(bytes, 24) == 16 && byte_at(bytes, 25) == 0;
}

bool has_depth_image_ending(const std::filesystem::path& path) {
  return ends_like(path, {".png", ".tif", ".tiff", ".exr", ".pfm", ".pgm", ".npy"});
}

bool has_photograph_ending(const std::filesystem::path& path) {
  return ends_like(path,
                   {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".ppm", ".bmp", ".tga", ".webp"});
}

}  // namespace relief
