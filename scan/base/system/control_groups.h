#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <string_view>

namespace relief {

// Control groups limit the memory of containers and batch jobs: of version 2 (`memory.max`) or 1
// (`memory.limit_in_bytes`). The groups around a group limit it as well. `root`: the folder that
// holds `proc` and `sys`; other than `/` for tests only.

/// Stands for no limit.
inline constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();

/// The least limit of the groups of this process [bytes]; kUnlimited when they have none.
std::size_t limit_of_groups(const std::filesystem::path& root = "/");

/// What the fullest of them has left [bytes]; kUnlimited when they have no limit. Copies of files
/// that can be dropped count as free.
std::size_t free_in_groups(const std::filesystem::path& root = "/");

/// What this process may take in all [bytes], where groups leave it less than the machine has: what
/// it has now, and what they have left. 0: they do not limit it.
std::size_t memory_in_groups(const std::filesystem::path& root = "/");

/// The number behind a key in a file of lines like `MemTotal:  24000000 kB` or `inactive_file
/// 4096`.
std::optional<std::size_t> number_after(const std::filesystem::path& file, std::string_view key);

}  // namespace relief
