#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "relief/scan/result.h"

namespace relief {

/// Writes a file whole or not at all: `write` fills a temporary file beside `path` (same folder,
/// same ending, since some writers choose the format by it), which is flushed to the disk and
/// renamed to `path` only if `write` succeeded. On failure the temporary is removed, an older
/// `path` stays as it was, and the error (kCannotWrite) names `path` and the reason. A device or
/// pipe is written to directly.
Result<void> write_atomically(
    const std::filesystem::path& path,
    const std::function<Result<void>(const std::filesystem::path&)>& write);

/// Writes a piece of a file.
using WritePiece = std::function<Result<void>(std::string_view)>;

/// The same for content that `produce` makes piece by piece. It ends with the first error.
Result<void> write_in_pieces(const std::filesystem::path& path,
                             const std::function<Result<void>(const WritePiece&)>& produce);

/// The same for content that is already in memory.
Result<void> write_file(const std::filesystem::path& path, std::string_view content);

/// A whole file in memory. kBadInput when it cannot be read.
Result<std::string> read_file(const std::filesystem::path& path);
/// Its bytes from `begin` to before `end`. kBadInput when it is shorter.
Result<std::string> read_file(const std::filesystem::path& path, std::size_t begin,
                              std::size_t end);

}  // namespace relief
