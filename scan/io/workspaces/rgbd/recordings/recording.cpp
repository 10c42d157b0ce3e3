#include "scan/io/workspaces/rgbd/recordings/recording.h"

#include "scan/io/workspaces/rgbd/recordings/bop_scene.h"
#include "scan/io/workspaces/rgbd/recordings/record3d.h"
#include "scan/io/workspaces/rgbd/recordings/stray_scanner.h"

namespace relief {

Result<std::optional<Recording>> find_recording(const std::filesystem::path& folder) {
  for (const auto read : {read_record3d_metadata, read_stray_scanner, read_bop_scene})
    if (auto found = read(folder); !found || *found) return found;
  return std::optional<Recording>();
}

}  // namespace relief
