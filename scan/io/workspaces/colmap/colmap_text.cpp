#include <charconv>
#include <limits>

#include "scan/io/workspaces/colmap/colmap_model.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

bool parse_colmap_id(std::string_view word, std::uint32_t& id) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), id);
  return error == std::errc() && end == word.data() + word.size();
}

std::string line_place(const NumberedLines& lines) {
  return "line " + std::to_string(lines.number()) + ": ";
}

Result<ColmapCamera> camera_of_line(std::string_view line, const NumberedLines& lines) {
  std::uint32_t id = 0;
  double width = 0.0, height = 0.0;
  const bool has_id = parse_colmap_id(next_word(line), id);
  const std::string model(next_word(line));
  if (!has_id || !parse_number(next_word(line), width) || !parse_number(next_word(line), height))
    return lines.error("expected 'CAMERA_ID MODEL WIDTH HEIGHT PARAMETERS'");
  return colmap_camera(id, model, width, height, leading_numbers(line), lines.path(),
                       line_place(lines));
}

Result<ColmapImage> image_of_line(std::string_view line, const NumberedLines& lines) {
  std::uint32_t id = 0, camera_id = 0;
  double pose[7];
  bool complete = parse_colmap_id(next_word(line), id);
  for (double& number : pose) complete = complete && parse_number(next_word(line), number);
  if (!complete || !parse_colmap_id(next_word(line), camera_id))
    return lines.error("expected 'IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME'");
  return colmap_image(id, camera_id, pose, trimmed(line), lines.path(), line_place(lines));
}

// `POINT3D_ID X Y Z R G B ERROR` and the track: pairs of an image and a feature in it.
bool add_point_of_line(std::string_view line, ColmapPoints& points) {
  double numbers[8];
  for (double& number : numbers)
    if (!parse_number(next_word(line), number)) return false;
  ColmapSighting sighting;
  sighting.point = static_cast<std::uint32_t>(points.points.size());
  for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
    std::uint32_t feature = 0;
    if (!parse_colmap_id(word, sighting.image_id) || !parse_colmap_id(next_word(line), feature))
      return false;
    points.sightings.push_back(sighting);
  }
  points.points.emplace_back(numbers[1], numbers[2], numbers[3]);
  return true;
}

}  // namespace

Result<std::vector<ColmapCamera>> parse_colmap_cameras_txt(std::string_view content,
                                                           const fs::path& path) {
  NumberedLines lines(content, path);
  std::vector<ColmapCamera> cameras;
  for (std::string_view line; lines.next(line);) {
    const auto camera = camera_of_line(line, lines);
    if (!camera) return camera.error();
    cameras.push_back(*camera);
  }
  return cameras;
}

Result<std::vector<ColmapImage>> parse_colmap_images_txt(std::string_view content,
                                                         const fs::path& path) {
  NumberedLines lines(content, path);
  std::vector<ColmapImage> images;
  for (std::string_view line; lines.next(line);) {
    auto image = image_of_line(line, lines);
    if (!image) return image.error();
    images.push_back(std::move(*image));
    lines.next_any(line);  // The features of the image, which may be none.
  }
  return images;
}

Result<ColmapPoints> parse_colmap_points_txt(std::string_view content, const fs::path& path) {
  NumberedLines lines(content, path);
  ColmapPoints points;
  for (std::string_view line; lines.next(line);)
    if (!add_point_of_line(line, points))
      return lines.error("expected 'POINT3D_ID X Y Z R G B ERROR' and pairs of numbers");
  return points;
}

}  // namespace relief
