#include <array>
#include <initializer_list>

#include <nlohmann/json.hpp>

#include "scan/io/files/io_error.h"
#include "scan/io/files/text_lines.h"
#include "scan/io/workspaces/rgbd/calibration/camera_files.h"

namespace relief {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::optional<double> number_at(const json& object, std::initializer_list<const char*> keys) {
  for (const char* key : keys)
    if (const auto found = object.find(key); found != object.end() && found->is_number())
      return found->get<double>();
  return std::nullopt;
}

// Three rows of three numbers, the last one 0 0 1.
std::optional<PinholeIntrinsics> intrinsics_of_rows(const json& rows) {
  if (!rows.is_array() || rows.size() != 3) return std::nullopt;
  Eigen::Matrix3d k;
  for (std::size_t r = 0; r < 3; ++r) {
    if (!rows[r].is_array() || rows[r].size() != 3) return std::nullopt;
    for (std::size_t c = 0; c < 3; ++c) {
      if (!rows[r][c].is_number()) return std::nullopt;
      k(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = rows[r][c].get<double>();
    }
  }
  if (k(0, 1) != 0.0 || k(1, 0) != 0.0 || k.row(2) != Eigen::RowVector3d(0, 0, 1))
    return std::nullopt;
  return PinholeIntrinsics{k(0, 0), k(1, 1), k(0, 2), k(1, 2)};
}

std::optional<PinholeIntrinsics> intrinsics_in(const json& camera) {
  const auto fx = number_at(camera, {"fx"}), fy = number_at(camera, {"fy"}),
             cx = number_at(camera, {"cx", "ppx"}), cy = number_at(camera, {"cy", "ppy"});
  if (fx && fy && cx && cy) return PinholeIntrinsics{*fx, *fy, *cx, *cy};
  for (const char* key : {"K", "camera_matrix", "intrinsics", "intrinsic"})
    if (const auto rows = camera.find(key); rows != camera.end())
      if (const auto found = intrinsics_of_rows(*rows)) return found;
  return std::nullopt;
}

std::optional<Calibration> calibration_in(const json& camera) {
  Calibration calibration;
  calibration.intrinsics = intrinsics_in(camera);
  if (!calibration.intrinsics) return std::nullopt;
  const auto width = number_at(camera, {"width", "w"}), height = number_at(camera, {"height", "h"});
  if (width && height) calibration.size = size_of_numbers(*width, *height);
  const auto scale = number_at(camera, {"depth_scale"});
  if (scale && *scale > 0.0) calibration.depth_scale = scale;
  return calibration;
}

}  // namespace

Result<std::optional<Calibration>> parse_camera_json(std::string_view text, const fs::path& path) {
  const json document = json::parse(without_byte_order_mark(text), nullptr, false);
  if (!document.is_object()) return std::optional<Calibration>();
  auto found = calibration_in(document);
  for (const char* part : {"depth", "camera", "intrinsics"})
    if (!found && document.contains(part) && document[part].is_object())
      found = calibration_in(document[part]);
  if (found && !can_be_intrinsics(*found->intrinsics))
    return bad_input(path, "the focal lengths fx and fy must be finite and not 0");
  return found;
}

}  // namespace relief
