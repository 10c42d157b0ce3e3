#pragma once

#include <cstddef>
#include <filesystem>

#include "relief/scan/result.h"
#include "scan/base/system/system_memory.h"

namespace relief {

/// The most pixels on a side of an image, and places on a side of a grid: bounds what a damaged
/// header makes a reader allocate.
inline constexpr int kMaxImageSide = 1 << 16;

/// The most that bytes of pixels can shrink to one byte of a file, by how they are stored.
inline constexpr std::size_t kUncompressed = 1;
inline constexpr std::size_t kDeflate = 1032;  ///< zlib's own bound.
/// 12-bit codes for strings of up to 3838 bytes, which is as long as a table makes them.
inline constexpr std::size_t kLzw = 2560;

/// What the header of an image says, before its pixels are read.
struct ImageHeader {
  std::size_t width = 0, height = 0;
  std::size_t pixel_bits = 0;  ///< Of all channels in the file, uncompressed.
  std::size_t channels = 1;    ///< That are read, as 32-bit floats.
  std::size_t compression = kUncompressed;
};

/// An error unless an image can be what its header says: a damaged header must not make the reader
/// allocate without bounds. An image has at most kMaxImageSide pixels on a side, 2^28 pixels, and
/// as many bytes as its compression can have shrunk to `file_bytes`. Beyond 2^26 pixels, where
/// nothing but a header may be behind the number, its file has a byte for at most 256 pixels. It
/// fits into `memory` [bytes]. Errors: kBadInput, and kUnsolvable for want of memory.
Result<void> check_image_header(const ImageHeader& header, std::size_t file_bytes,
                                const std::filesystem::path& path,
                                std::size_t memory = free_memory());

}  // namespace relief
