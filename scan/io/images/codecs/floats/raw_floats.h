#pragma once

#include <filesystem>
#include <string_view>

#include "relief/scan/result.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/image_size.h"

namespace relief {

/// Whether a file name ends like one of bare floats: .raw or .f32.
bool has_raw_ending(const std::filesystem::path& path);

/// 32-bit floats without a header, least significant byte first, row by row from the top; three to
/// a pixel where the file has three times as many. kBadInput unless the file has just these bytes.
Result<Image> decode_raw_floats(std::string_view content, const ImageSize& size,
                                const std::filesystem::path& path);

}  // namespace relief
