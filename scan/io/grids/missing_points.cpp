#include "scan/io/grids/missing_points.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "relief/scan/range_view.h"
#include "scan/io/images/invalid_depth.h"

namespace relief {

namespace {

bool at_origin(const Eigen::Vector3d& point) { return point.isZero(0.0); }

// In the precision of most files, which rounds equal depths alike.
float depth_of(const Eigen::Vector3d& point) { return static_cast<float>(std::abs(point.z())); }

float invalid_depth_of(std::span<const Eigen::Vector3d> points) {
  std::vector<float> depths(points.size());
  std::ranges::transform(points, depths.begin(), depth_of);
  return static_cast<float>(invalid_depth_value(depths));
}

// Returns how many points are gone.
template <typename Missing>
std::size_t invalidate_if(std::span<Eigen::Vector3d> points, const Missing& missing) {
  std::size_t count = 0;
  for (Eigen::Vector3d& point : points) {
    if (!missing(point)) continue;
    point.setConstant(kNoSample);
    ++count;
  }
  return count;
}

std::string invalidate_depth(std::span<Eigen::Vector3d> points, float invalid) {
  const std::size_t count =
      invalidate_if(points, [&](const Eigen::Vector3d& p) { return depth_of(p) == invalid; });
  std::ostringstream note;
  note << count << " points at the depth " << invalid
       << ", far behind all others, are taken for missing samples";
  return note.str();
}

}  // namespace

MissingPoints invalidate_missing_points(std::span<Eigen::Vector3d> points) {
  MissingPoints missing;
  missing.at_origin = std::ranges::count_if(points, at_origin) > 1;
  if (missing.at_origin)
    missing.notes.push_back(std::to_string(invalidate_if(points, at_origin)) +
                            " points at the origin are taken for missing samples");
  if (const float invalid = invalid_depth_of(points); std::isfinite(invalid))
    missing.notes.push_back(invalidate_depth(points, invalid));
  return missing;
}

MissingPoints invalidate_missing_corners(std::span<Eigen::Vector3d> points) {
  const float invalid = invalid_depth_of(points);
  if (!is_largest_of_16_bits(invalid)) return {};
  return {false, {invalidate_depth(points, invalid)}};
}

bool hold_directions(std::span<const Eigen::Vector3f> normals) {
  return std::ranges::any_of(normals, [](const Eigen::Vector3f& normal) {
    return normal.allFinite() && !normal.isZero(0.0f);
  });
}

}  // namespace relief
