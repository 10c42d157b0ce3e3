#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "relief/scan/result.h"

namespace relief {

/// Holds the headers of an OpenEXR file against its size, before the library, which allocates by
/// what they say, opens it: attributes end within the file; the image is one that
/// check_image_header() accepts, all channels counted; every chunk (some scan lines, or a tile) has
/// its entry in the table of offsets; and what is unpacked at once, a chunk or a row of tiles, is
/// no larger than the image or 64 MiB. Errors: kBadInput, and kUnsolvable for want of memory.
Result<void> check_exr_headers(std::string_view content, const std::filesystem::path& path);

}  // namespace relief
