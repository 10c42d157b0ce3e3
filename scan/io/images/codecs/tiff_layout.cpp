#include "scan/io/images/codecs/tiff_layout.h"

#include <string>

#include <tiffio.h>

#include "scan/io/files/io_error.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

bool is_supported(const TiffLayout& layout) {
  if (layout.samples_per_pixel < 1 || layout.samples_per_pixel > 4) return false;
  if (layout.format == SAMPLEFORMAT_UINT) return layout.bits == 8 || layout.bits == 16;
  if (layout.format == SAMPLEFORMAT_IEEEFP)
    return layout.bits == 16 || layout.bits == 32 || layout.bits == 64;
  return false;
}

// Why the samples are not grey or RGB values of known places; empty: they are.
std::string unsupported_meaning(const TiffLayout& layout) {
  switch (layout.photometric) {
    case PHOTOMETRIC_MINISBLACK:
    case PHOTOMETRIC_RGB:
      break;
    case PHOTOMETRIC_MINISWHITE:
      if (layout.format == SAMPLEFORMAT_IEEEFP)
        return "its least number is white (photometric interpretation 0), and real numbers have no "
               "black to count from; save it with the least as black";
      break;
    case PHOTOMETRIC_PALETTE:
      return "its pixels are places in a colour palette (photometric interpretation 3); save it as "
             "grey or RGB";
    default:
      return "its photometric interpretation is " + std::to_string(layout.photometric) +
             "; save it as grey or RGB";
  }
  if (layout.orientation < ORIENTATION_TOPLEFT || layout.orientation > ORIENTATION_LEFTBOT)
    return "its orientation is " + std::to_string(layout.orientation) + "; save it with 1 to 8";
  return {};
}

// Bytes of pixels in a byte of the file, at most.
std::size_t most_compression(std::uint16_t compression) {
  switch (compression) {
    case COMPRESSION_NONE:
      return kUncompressed;
    case COMPRESSION_PACKBITS:
      return 64;  // 128 bytes in two
    case COMPRESSION_LZW:
      return kLzw;
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE:
      return kDeflate;
    default:
      return 1u << 15;  // Zstandard: 128 KiB in four bytes
  }
}

ImageHeader header_of(const TiffLayout& layout) {
  ImageHeader header;
  header.width = layout.width;
  header.height = layout.height;
  header.pixel_bits = std::size_t{layout.samples_per_pixel} * layout.bits;
  header.channels = static_cast<std::size_t>(layout.channels());
  header.compression = most_compression(layout.compression);
  return header;
}

}  // namespace

TiffLayout read_tiff_layout(tiff* file) {
  TiffLayout layout;
  TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &layout.width);
  TIFFGetField(file, TIFFTAG_IMAGELENGTH, &layout.height);
  TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLESPERPIXEL, &layout.samples_per_pixel);
  TIFFGetFieldDefaulted(file, TIFFTAG_BITSPERSAMPLE, &layout.bits);
  TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLEFORMAT, &layout.format);
  TIFFGetFieldDefaulted(file, TIFFTAG_PLANARCONFIG, &layout.planar);
  TIFFGetFieldDefaulted(file, TIFFTAG_ORIENTATION, &layout.orientation);
  TIFFGetField(file, TIFFTAG_PHOTOMETRIC, &layout.photometric);
  TIFFGetFieldDefaulted(file, TIFFTAG_COMPRESSION, &layout.compression);
  if (layout.format == SAMPLEFORMAT_VOID) layout.format = SAMPLEFORMAT_UINT;
  return layout;
}

Result<void> check_tiff_layout(const TiffLayout& layout, std::size_t file_bytes,
                               const std::filesystem::path& path) {
  if (!is_supported(layout))
    return bad_input(
        path, "unsupported TIFF: " + std::to_string(layout.samples_per_pixel) + " samples of " +
                  std::to_string(layout.bits) +
                  " bits; use 8 or 16 bit unsigned integers or 16, 32 or 64 bit float");
  if (const auto why = unsupported_meaning(layout); !why.empty())
    return bad_input(path, "unsupported TIFF: " + why);
  return check_image_header(header_of(layout), file_bytes, path);
}

Image upright(Image image, std::uint16_t orientation) {
  if (orientation == ORIENTATION_TOPLEFT) return image;
  const bool swapped = orientation >= ORIENTATION_LEFTTOP;  // Rows are columns.
  const bool from_right =
      orientation == ORIENTATION_TOPRIGHT || orientation == ORIENTATION_BOTRIGHT ||
      orientation == ORIENTATION_RIGHTTOP || orientation == ORIENTATION_RIGHTBOT;
  const bool from_bottom =
      orientation == ORIENTATION_BOTRIGHT || orientation == ORIENTATION_BOTLEFT ||
      orientation == ORIENTATION_RIGHTBOT || orientation == ORIENTATION_LEFTBOT;
  Image result(swapped ? image.height : image.width, swapped ? image.width : image.height,
               image.channels, image.max_value);
  for (int v = 0; v < result.height; ++v) {
    for (int u = 0; u < result.width; ++u) {
      const int across = from_right ? result.width - 1 - u : u;
      const int down = from_bottom ? result.height - 1 - v : v;
      for (int c = 0; c < image.channels; ++c)
        result(u, v, c) = swapped ? image(down, across, c) : image(across, down, c);
    }
  }
  return result;
}

}  // namespace relief
