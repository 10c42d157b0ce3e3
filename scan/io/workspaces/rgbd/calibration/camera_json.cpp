#include <cmath>
#include <initializer_list>
#include <vector>

#include <nlohmann/json.hpp>

#include "scan/io/files/text_lines.h"
#include "scan/io/workspaces/rgbd/calibration/camera_files.h"

namespace relief {

namespace {

using nlohmann::json;

std::optional<double> number_at(const json& object, std::initializer_list<const char*> keys) {
  for (const char* key : keys)
    if (const auto found = object.find(key); found != object.end() && found->is_number())
      return found->get<double>();
  return std::nullopt;
}

std::optional<PinholeIntrinsics> intrinsics_of_rows(const json& rows) {
  std::vector<double> numbers;
  if (!rows.is_array()) return std::nullopt;
  for (const json& row : rows) {
    if (!row.is_array()) return std::nullopt;
    for (const json& number : row)
      numbers.push_back(number.is_number() ? number.get<double>() : std::nan(""));
  }
  return intrinsics_of_matrix(numbers);
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
  if (!calibration.intrinsics || !can_be_intrinsics(*calibration.intrinsics)) return std::nullopt;
  const auto width = number_at(camera, {"width", "w"}), height = number_at(camera, {"height", "h"});
  if (width && height) calibration.size = size_of_numbers(*width, *height);
  const auto scale = number_at(camera, {"depth_scale"});
  if (scale && *scale > 0.0) calibration.depth_scale = scale;
  return calibration;
}

}  // namespace

std::optional<Calibration> parse_camera_json(std::string_view text) {
  const json document = json::parse(without_byte_order_mark(text), nullptr, false);
  if (!document.is_object()) return std::nullopt;
  auto found = calibration_in(document);
  for (const char* part : {"depth", "camera", "intrinsics"})
    if (!found && document.contains(part) && document[part].is_object())
      found = calibration_in(document[part]);
  return found;
}

}  // namespace relief
