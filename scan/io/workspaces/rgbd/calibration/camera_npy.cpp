#include <vector>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/floats/npy_header.h"
#include "scan/io/workspaces/rgbd/calibration/camera_files.h"

namespace relief {

Result<std::optional<Calibration>> parse_camera_npy(std::string_view content,
                                                    const std::filesystem::path& path) {
  const auto header = read_npy_header(content, path);
  if (!header) return header.error();
  const auto k = read_npy_floats(content, *header);
  if (header->shape != std::vector<std::size_t>{3, 3} || k.size() != 9)
    return std::optional<Calibration>();
  Calibration calibration;
  calibration.intrinsics = PinholeIntrinsics{k[0], k[4], k[2], k[5]};
  if (!can_be_intrinsics(*calibration.intrinsics))
    return bad_input(path, "the focal lengths must be finite and not 0");
  return std::optional(std::move(calibration));
}

}  // namespace relief
