#pragma once

#include <filesystem>
#include <system_error>

namespace relief {

/// The absolute path without links, `.` and `..`, as far as it exists.
inline std::filesystem::path real_path(const std::filesystem::path& path) {
  std::error_code code;
  return std::filesystem::weakly_canonical(std::filesystem::absolute(path, code), code);
}

}  // namespace relief
