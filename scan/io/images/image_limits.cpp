#include "scan/io/images/image_limits.h"

#include <string>

#include "scan/io/files/io_error.h"

namespace relief {

namespace {

// Bounds the memory: 1 GiB for a channel of floats.
constexpr std::size_t kMaxPixels = 1u << 28;
// Masks of the largest cameras have as many in a few kilobytes.
constexpr std::size_t kPixelsOfAnyFile = 1u << 26;
constexpr std::size_t kPixelsPerByte = 256;

std::string mebibytes(std::size_t bytes) { return std::to_string((bytes >> 20) + 1) + " MiB"; }

}  // namespace

Result<void> check_image_header(const ImageHeader& header, std::size_t file_bytes,
                                const std::filesystem::path& path, std::size_t memory) {
  const std::size_t width = header.width, height = header.height;
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  if (width == 0 || height == 0) return bad_input(path, "the image is empty (" + size + ")");
  if (width > kMaxImageSide || height > kMaxImageSide || width * height > kMaxPixels)
    return bad_input(path, "the header says " + size + " pixels, more than can be read");
  const std::size_t pixels = width * height, stored = pixels * header.pixel_bits / 8;
  if (stored / header.compression > file_bytes ||
      (pixels > kPixelsOfAnyFile && pixels / kPixelsPerByte > file_bytes))
    return bad_input(path, "the header says " + size + " pixels, far more than a file of " +
                               std::to_string(file_bytes) + " bytes can hold; it is truncated");
  const std::size_t needed = stored + pixels * header.channels * sizeof(float);
  if (needed > memory)
    return Error{ErrorKind::kUnsolvable,
                 path.string() + ": " + size + " pixels take " + mebibytes(needed) +
                     " of memory, and less is free; give an image of less resolution"};
  return {};
}

}  // namespace relief
