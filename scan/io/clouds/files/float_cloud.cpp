#include "scan/io/clouds/files/float_cloud.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "scan/io/clouds/grey_of_intensity.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/little_endian.h"

namespace relief {

namespace {

constexpr std::size_t kLooked = 64;  // Points that tell what a file holds.
constexpr std::size_t kFewest = 64;  // Fewer are no sweep.
constexpr float kFarthest = 500.0f;  // What lidars of cars see [m].
constexpr float kLargestIntensity = 256.0f, kMostRings = 256.0f;

float float_at(std::string_view bytes, std::size_t i) {
  return little_endian_at<float>(bytes, sizeof(float) * i);
}

// Other numbers, read as floats, are far too large or far too small.
bool is_place(float coordinate) {
  return std::isfinite(coordinate) && std::abs(coordinate) < kFarthest &&
         (coordinate == 0.0f || std::abs(coordinate) > 1e-6f);
}

bool are_points(std::string_view head, std::size_t columns) {
  const std::size_t points = std::min(kLooked, head.size() / sizeof(float) / columns);
  std::size_t away = 0;
  for (std::size_t i = 0; i < points; ++i) {
    const auto column = [&](std::size_t c) { return float_at(head, columns * i + c); };
    if (!is_place(column(0)) || !is_place(column(1)) || !is_place(column(2))) return false;
    const float intensity = column(3);
    if (!(intensity >= 0.0f) || intensity >= kLargestIntensity) return false;
    if (columns == 5 &&
        !(column(4) >= 0.0f && column(4) < kMostRings && column(4) == std::floor(column(4))))
      return false;
    away += std::hypot(column(0), column(1), column(2)) > 0.1f ? 1 : 0;
  }
  return points == kLooked && 2 * away > points;
}

// Floats of each point; nothing where the file holds something else.
std::optional<std::size_t> columns_of(std::string_view head, std::size_t file_bytes) {
  for (const std::size_t columns : {4, 5}) {
    const std::size_t point_bytes = columns * sizeof(float);
    if (file_bytes % point_bytes == 0 && file_bytes >= kFewest * point_bytes &&
        are_points(head, columns))
      return columns;
  }
  return std::nullopt;
}

std::string head_of(const std::filesystem::path& path) {
  std::string head(kLooked * 5 * sizeof(float), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head;
}

}  // namespace

bool is_float_cloud(const std::filesystem::path& path) {
  std::error_code code;
  const auto bytes = std::filesystem::file_size(path, code);
  return !code && columns_of(head_of(path), bytes).has_value();
}

Result<PointCloudFile> read_float_cloud(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return content.error();
  const auto columns = columns_of(*content, content->size());
  if (!columns)
    return bad_input(path, "no points of a lidar: 4 or 5 floats each, x y z intensity first");
  const std::size_t count = content->size() / sizeof(float) / *columns;
  PointCloudFile cloud;
  cloud.points.reserve(count);
  GreyOfIntensity grey;
  for (std::size_t i = 0; i < count; ++i) {
    const auto column = [&](std::size_t c) {
      return static_cast<double>(float_at(*content, *columns * i + c));
    };
    cloud.points.emplace_back(column(0), column(1), column(2));
    grey.add(column(3));
  }
  if (grey.known()) {
    cloud.colours.reserve(count);
    for (std::size_t i = 0; i < count; ++i)
      cloud.colours.push_back(grey.grey(float_at(*content, *columns * i + 3)));
  }
  cloud.viewpoint = Eigen::Vector3d::Zero();
  return cloud;
}

}  // namespace relief
