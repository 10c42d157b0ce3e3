#include "scan/io/clouds/files/velodyne_bin.h"

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

constexpr std::size_t kLooked = 64;          // Points, evenly over a file, that tell what it holds.
constexpr std::size_t kFewest = 64;          // Fewer are no sweep.
constexpr float kFarthest = 500.0f;          // What lidars of cars see [m].
constexpr float kNearest = 1e-20f;           // Whole numbers, read as floats, are smaller [m].
constexpr float kLargestIntensity = 256.0f;  // Of those that count to 255, or to 1.
constexpr float kMostRings = 256.0f;         // Lidars have up to 128 lasers.

float float_at(std::string_view bytes, std::size_t i) {
  return little_endian_at<float>(bytes, sizeof(float) * i);
}

// Other numbers, read as floats, are far too large or far too small.
bool is_place(float coordinate) {
  return std::isfinite(coordinate) && std::abs(coordinate) < kFarthest &&
         (coordinate == 0.0f || std::abs(coordinate) > kNearest);
}

// `point(i)`: the bytes of the i-th of those that are looked at.
template <typename PointBytes>
bool are_points(const PointBytes& point, std::size_t columns) {
  std::size_t away = 0, left = 0;
  for (std::size_t i = 0; i < kLooked; ++i) {
    const std::string_view bytes = point(i);
    if (bytes.size() < columns * sizeof(float)) return false;
    const auto column = [&](std::size_t c) { return float_at(bytes, c); };
    if (!is_place(column(0)) || !is_place(column(1)) || !is_place(column(2))) return false;
    if (!(column(3) >= 0.0f) || column(3) >= kLargestIntensity) return false;
    if (columns == 5 &&
        !(column(4) >= 0.0f && column(4) < kMostRings && column(4) == std::floor(column(4))))
      return false;
    away += std::hypot(column(0), column(1), column(2)) > 0.1f ? 1 : 0;
    left += column(1) > 0.0f ? 1 : 0;
  }
  // A sweep goes from the right to the left. Depth maps and other arrays have one sign.
  return 2 * away > kLooked && left > 0 && left < kLooked;
}

// Floats of each point; nothing where the file holds something else. `bytes_at(place, count)`: of
// the file.
template <typename BytesAt>
std::optional<std::size_t> columns_of(const BytesAt& bytes_at, std::size_t file_bytes) {
  for (const std::size_t columns : {5, 4}) {
    const std::size_t point_bytes = columns * sizeof(float);
    const std::size_t points = file_bytes / point_bytes;
    if (file_bytes % point_bytes != 0 || points < kFewest) continue;
    const auto point = [&](std::size_t i) {
      return bytes_at(i * points / kLooked * point_bytes, point_bytes);
    };
    if (are_points(point, columns)) return columns;
  }
  return std::nullopt;
}

}  // namespace

bool is_velodyne_bin(const std::filesystem::path& path) {
  std::error_code code;
  const auto bytes = std::filesystem::file_size(path, code);
  if (code) return false;
  std::ifstream file(path, std::ios::binary);
  std::string read;
  const auto bytes_at = [&](std::size_t place, std::size_t count) -> std::string_view {
    read.assign(count, '\0');
    file.seekg(static_cast<std::streamoff>(place));
    if (!file.read(read.data(), static_cast<std::streamsize>(count))) return {};
    return read;
  };
  return columns_of(bytes_at, bytes).has_value();
}

Result<PointCloudFile> read_velodyne_bin(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return content.error();
  const auto bytes_at = [&](std::size_t place, std::size_t count) {
    return std::string_view(*content).substr(place, count);
  };
  const auto columns = columns_of(bytes_at, content->size());
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
