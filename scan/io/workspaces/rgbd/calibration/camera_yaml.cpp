#include <algorithm>
#include <initializer_list>
#include <string>
#include <vector>

#include "scan/io/workspaces/rgbd/calibration/camera_files.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// The text behind `name:` where a line begins with it; nothing without such a line.
std::optional<std::string_view> text_behind(std::string_view text, std::string_view name) {
  while (!text.empty()) {
    const std::string_view rest = text;
    const std::string_view line = trimmed(next_line(text));
    if (!line.starts_with(name) || !line.substr(name.size()).starts_with(':')) continue;
    return rest.substr(rest.find(':') + 1);
  }
  return std::nullopt;
}

std::optional<double> number_behind(std::string_view text,
                                    std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names)
    if (auto behind = text_behind(text, name)) {
      const auto numbers = leading_numbers(next_line(*behind), 1);
      if (!numbers.empty()) return numbers.front();
    }
  return std::nullopt;
}

std::vector<double> numbers_in_brackets(std::optional<std::string_view> text) {
  const std::size_t open = text ? text->find('[') : std::string_view::npos;
  const std::size_t close = text ? text->find(']') : std::string_view::npos;
  if (open == std::string_view::npos || close == std::string_view::npos || close < open) return {};
  return leading_numbers(with_blanks(text->substr(open + 1, close - open - 1), ",\n"));
}

// Behind the `data` of `camera_matrix`, or behind the `K` of ROS.
std::optional<PinholeIntrinsics> matrix_in(std::string_view text) {
  const auto matrix = text_behind(text, "camera_matrix");
  return intrinsics_of_matrix(
      numbers_in_brackets(matrix ? text_behind(*matrix, "data") : text_behind(text, "K")));
}

// The coefficients of ORB-SLAM, or those in brackets of OpenCV and ROS.
bool has_distortion(std::string_view text) {
  for (const std::string_view name : {"k1", "k2", "k3", "p1", "p2"})
    if (number_behind(text, {"Camera." + std::string(name), "Camera1." + std::string(name)})
            .value_or(0.0) != 0.0)
      return true;
  const auto coefficients = text_behind(text, "distortion_coefficients");
  const auto data = coefficients ? numbers_in_brackets(text_behind(*coefficients, "data"))
                                 : numbers_in_brackets(text_behind(text, "D"));
  return std::ranges::any_of(data, [](double k) { return k != 0.0; });
}

}  // namespace

std::optional<Calibration> parse_camera_yaml(std::string_view text, const fs::path& path) {
  Calibration calibration;
  const auto fx = number_behind(text, {"Camera.fx", "Camera1.fx"}),
             fy = number_behind(text, {"Camera.fy", "Camera1.fy"}),
             cx = number_behind(text, {"Camera.cx", "Camera1.cx"}),
             cy = number_behind(text, {"Camera.cy", "Camera1.cy"});
  calibration.intrinsics =
      fx && fy && cx && cy ? std::optional(PinholeIntrinsics{*fx, *fy, *cx, *cy}) : matrix_in(text);
  if (!calibration.intrinsics || !can_be_intrinsics(*calibration.intrinsics)) return std::nullopt;
  const auto width = number_behind(text, {"Camera.width", "image_width", "width"}),
             height = number_behind(text, {"Camera.height", "image_height", "height"});
  if (width && height) calibration.size = size_of_numbers(*width, *height);
  const auto scale = number_behind(text, {"DepthMapFactor", "RGBD.DepthMapFactor"});
  if (scale && *scale > 0.0) calibration.depth_scale = scale;
  if (has_distortion(text))
    calibration.notes.push_back("coefficients of distortion in " + path.filename().string() +
                                " are not applied");
  return calibration;
}

}  // namespace relief
