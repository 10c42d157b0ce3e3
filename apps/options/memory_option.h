#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace relief {

/// Memory of the whole process.
struct MemoryFlag {
  /// 0: no limit. Not given: what control groups leave (a container, a batch job), if they do.
  std::optional<std::size_t> mebibytes;

  /// The limit now, 0: none. `root`: see memory_in_groups().
  std::size_t bytes(const std::filesystem::path& root = "/") const;
};

/// Carries out a command within its limit: what does not fit lies in temporary files in `folder`,
/// or in the nearest folder round it that exists already.
int work_within(const MemoryFlag& memory, const std::filesystem::path& folder,
                const std::function<int()>& work);

/// `what`: what is done to keep to the limit.
void add_memory_option(CLI::App& command, MemoryFlag& flag, const std::string& what);

}  // namespace relief
