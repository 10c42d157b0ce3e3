#include "scan/io/workspaces/rgbd/recordings/recording.h"

#include <cmath>

#include "scan/io/files/text_lines.h"
#include "scan/io/workspaces/rgbd/recordings/bop_scene.h"
#include "scan/io/workspaces/rgbd/recordings/record3d.h"
#include "scan/io/workspaces/rgbd/recordings/stray_scanner.h"

namespace relief {

std::optional<int> frame_number(std::string_view name) {
  double number = -1.0;
  if (!parse_number(name, number) || number != std::floor(number) || !(number >= 0.0) ||
      !(number <= 1e9))
    return std::nullopt;
  return static_cast<int>(number);
}

Result<std::optional<Recording>> find_recording(const std::filesystem::path& folder) {
  for (const auto read : {read_record3d_metadata, read_stray_scanner, read_bop_scene})
    if (auto found = read(folder); !found || *found) return found;
  return std::optional<Recording>();
}

}  // namespace relief
