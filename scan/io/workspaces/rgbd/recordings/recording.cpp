#include "scan/io/workspaces/rgbd/recordings/recording.h"

#include <cstddef>

#include "scan/io/workspaces/rgbd/recordings/bop_scene.h"
#include "scan/io/workspaces/rgbd/recordings/record3d.h"
#include "scan/io/workspaces/rgbd/recordings/stray_scanner.h"

namespace relief {

std::optional<int> frame_number(std::string_view name) {
  constexpr std::string_view kDigits = "0123456789";
  constexpr std::size_t kMostDigits = 9;
  const std::size_t first = name.find_first_of(kDigits), last = name.find_last_of(kDigits);
  if (first == std::string_view::npos || last - first >= kMostDigits) return std::nullopt;
  int number = 0;
  for (const char c : name.substr(first, last - first + 1)) {
    if (kDigits.find(c) == std::string_view::npos) return std::nullopt;
    number = 10 * number + (c - '0');
  }
  return number;
}

Result<std::optional<Recording>> find_recording(const std::filesystem::path& folder) {
  for (const auto read : {read_record3d_metadata, read_stray_scanner, read_bop_scene})
    if (auto found = read(folder); !found || *found) return found;
  return std::optional<Recording>();
}

}  // namespace relief
