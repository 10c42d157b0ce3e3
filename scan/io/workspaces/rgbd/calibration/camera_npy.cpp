#include <vector>

#include "scan/io/images/codecs/floats/npy_header.h"
#include "scan/io/workspaces/rgbd/calibration/camera_files.h"

namespace relief {

std::optional<Calibration> parse_camera_npy(std::string_view content,
                                            const std::filesystem::path& path) {
  const auto header = read_npy_header(content, path);
  using Shape = std::vector<std::size_t>;
  if (!header || (header->shape != Shape{3, 3} && header->shape != Shape{1, 3, 3}))
    return std::nullopt;
  Calibration calibration;
  calibration.intrinsics = intrinsics_of_matrix(read_npy_floats(content, *header));
  return calibration.intrinsics ? std::optional(std::move(calibration)) : std::nullopt;
}

}  // namespace relief
