#include "scan/io/workspaces/middlebury_par.h"

#include <cmath>

#include "scan/io/files/atomic_file.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

using RowMatrix3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Result<PinholeIntrinsics> intrinsics_of_par(const double* numbers, const NumberedLines& lines) {
  const Eigen::Matrix3d k = Eigen::Map<const RowMatrix3d>(numbers) / numbers[8];
  if (!k.allFinite() || k(0, 0) == 0.0 || k(1, 1) == 0.0)
    return lines.error("k11, k22 and k33 must not be 0");
  // Of the focal length. Rounding of decomposed projection matrices leaves traces of skew; in an
  // image of 4000 pixels over 90 degrees 1e-6 moves none by more than 0.002.
  constexpr double kSkewOfRounding = 1e-6;
  if (std::abs(k(0, 1)) > kSkewOfRounding * std::abs(k(0, 0)) || k(1, 0) != 0.0 || k(2, 0) != 0.0 ||
      k(2, 1) != 0.0)
    return lines.error("the camera has skew, k12 or an entry below the diagonal; it must be 0");
  return PinholeIntrinsics{k(0, 0), k(1, 1), k(0, 2), k(1, 2)};
}

Result<MiddleburyCamera> camera_of_par(std::string_view line, const NumberedLines& lines) {
  MiddleburyCamera camera;
  camera.file = std::string(next_word(line));
  double numbers[21];
  if (!parse_row(line, 21, numbers))
    return lines.error("expected 'name k11 ... k33 r11 ... r33 t1 t2 t3', a name and 21 numbers");
  const auto intrinsics = intrinsics_of_par(numbers, lines);
  if (!intrinsics) return intrinsics.error();
  camera.intrinsics = *intrinsics;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = Eigen::Map<const RowMatrix3d>(numbers + 9);
  matrix.topRightCorner<3, 1>() = Eigen::Map<const Eigen::Vector3d>(numbers + 18);
  const auto view_from_world = rigid_motion_from_matrix(matrix, "[R t] of " + camera.file);
  if (!view_from_world) return lines.error(view_from_world.error().message);
  camera.world_from_view = view_from_world->inverse();
  return camera;
}

}  // namespace

Result<std::vector<MiddleburyCamera>> parse_middlebury_par(std::string_view text,
                                                           const std::filesystem::path& path) {
  NumberedLines lines(text, path);
  std::string_view line;
  if (!lines.next(line)) return lines.end_error("the number of images");
  double count = 0.0;
  if (!parse_row(line, 1, &count) || !(count >= 1.0) || count != std::floor(count))
    return lines.error("expected the number of images");
  std::vector<MiddleburyCamera> cameras;
  while (lines.next(line)) {
    if (static_cast<double>(cameras.size()) == count)
      return lines.error("more images than the first line says");
    auto camera = camera_of_par(line, lines);
    if (!camera) return camera.error();
    cameras.push_back(std::move(*camera));
  }
  if (static_cast<double>(cameras.size()) < count) return lines.end_error("another image");
  return cameras;
}

Result<std::vector<MiddleburyCamera>> read_middlebury_par(const std::filesystem::path& path) {
  const auto text = read_file(path);
  if (!text) return text.error();
  return parse_middlebury_par(*text, path);
}

}  // namespace relief
