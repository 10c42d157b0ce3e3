// libFuzzer target over the parsers of other programs' projects that work in memory. The first byte
// selects the parser, the rest is the file.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "scan/io/images/codecs/floats/colmap_array.h"
#include "scan/io/workspaces/colmap/colmap_model.h"
#include "scan/io/workspaces/meshlab_mlp.h"
#include "scan/io/workspaces/middlebury_par.h"
#include "scan/io/workspaces/pose_beside.h"
#include "scan/io/workspaces/rgbd/calibration.h"
#include "scan/io/workspaces/rgbd/trajectories.h"

namespace relief {
namespace {

using Parse = void (*)(std::string_view content);

template <auto kParser>
void parse_with(std::string_view content) {
  static const std::filesystem::path path = "fuzz";
  (void)kParser(content, path);
}

Result<ProjectSpec> parse_mlp(std::string_view content, const std::filesystem::path& path) {
  return parse_meshlab_mlp(std::string(content), path);
}

Result<bool> look_at(std::string_view content, const std::filesystem::path&) {
  return kind_of_rgbd_text(content) == RgbdText::kUnknown;
}

constexpr std::array<Parse, 17> kParsers = {parse_with<decode_colmap_array>,
                                            parse_with<parse_colmap_cameras_bin>,
                                            parse_with<parse_colmap_images_bin>,
                                            parse_with<parse_colmap_points_bin>,
                                            parse_with<parse_colmap_cameras_txt>,
                                            parse_with<parse_colmap_images_txt>,
                                            parse_with<parse_colmap_points_txt>,
                                            parse_with<parse_tum_list>,
                                            parse_with<parse_tum_associations>,
                                            parse_with<parse_tum_trajectory>,
                                            parse_with<parse_log_trajectory>,
                                            parse_with<parse_open3d_trajectory>,
                                            parse_with<parse_open3d_camera>,
                                            parse_with<parse_calibration_text>,
                                            parse_with<parse_matrix_text>,
                                            parse_with<parse_middlebury_par>,
                                            parse_with<parse_mlp>};

}  // namespace
}  // namespace relief

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view content(reinterpret_cast<const char*>(data) + 1, size - 1);
  relief::kParsers[data[0] % relief::kParsers.size()](content);
  (void)relief::look_at(content, "fuzz");
  return 0;
}
