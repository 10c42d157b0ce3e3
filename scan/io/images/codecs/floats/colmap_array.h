#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

#include "relief/scan/result.h"
#include "scan/io/images/image_io.h"

namespace relief {

/// The depth and normal maps of a COLMAP workspace: the text `width&height&channels&`, then 32-bit
/// floats, least significant byte first, channel after channel, each row by row from the top.
/// The result has real samples (`max_value` 0). kBadInput for anything but 1 or 3 channels and for
/// a file whose size is not what its header says.
Result<Image> read_colmap_array(const std::filesystem::path& path);

/// The same for the content of `path`.
Result<Image> decode_colmap_array(std::string_view content, const std::filesystem::path& path);

}  // namespace relief
