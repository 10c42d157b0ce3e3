#pragma once

#include <filesystem>
#include <string>

#include "relief/rendering/picture.h"
#include "relief/scan/result.h"

namespace relief {

/// Writes a picture as PNG with `description` as its remark, whole or not at all. Pixels have an
/// opacity where the background is transparent.
Result<void> write_picture(const rendering::Picture& picture, rendering::Background background,
                           const std::string& description, const std::filesystem::path& path);

/// The bytes of a picture as PNG, likewise.
Result<std::string> png_of(const rendering::Picture& picture, rendering::Background background,
                           const std::string& description);

}  // namespace relief
