#include "scan/io/grids/cameras/grid_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Dense>

#include "scan/base/median.h"

namespace relief {

GridSamples collect_samples(const Grid<Eigen::Vector3d>& points) {
  GridSamples samples;
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (!points(u, v).allFinite()) continue;
      samples.points.push_back(points(u, v));
      samples.pixels.emplace_back(u, v);
      samples.mean += points(u, v);
    }
  }
  if (!samples.points.empty()) samples.mean /= static_cast<double>(samples.points.size());
  return samples;
}

RationalProjection projection_of(const Camera& camera) {
  const auto& k = camera.intrinsics();
  switch (camera.model()) {
    case Camera::Model::kPinhole:
      return {{k.fx, 0, k.cx, 0}, {0, 0, 1, 0}, {0, k.fy, k.cy, 0}, {0, 0, 1, 0}};
    case Camera::Model::kPinholeGl:
      return {{k.fx, 0, -k.cx, 0}, {0, 0, -1, 0}, {0, k.fy, -k.cy, 0}, {0, 0, -1, 0}};
    case Camera::Model::kOrthographic: {
      const Ray origin = camera.ray_at(0, 0);
      Eigen::Matrix3d axes;
      axes << camera.ray_at(1, 0).origin - origin.origin,
          camera.ray_at(0, 1).origin - origin.origin, origin.direction;
      const Eigen::Matrix3d inverse = axes.inverse();
      RationalProjection projection;
      projection.u_denominator = projection.v_denominator = Eigen::Vector4d::UnitW();
      projection.u_numerator << inverse.row(0).transpose(), -inverse.row(0).dot(origin.origin);
      projection.v_numerator << inverse.row(1).transpose(), -inverse.row(1).dot(origin.origin);
      return projection;
    }
    case Camera::Model::kSpherical:
    case Camera::Model::kRayTable:
      break;
  }
  return camera.projection().value_or(RationalProjection{});
}

double median_distance_beside(const Grid<Eigen::Vector3d>& points, int du, int dv) {
  std::vector<double> distances;
  for (int v = 0; v + dv < points.height(); ++v)
    for (int u = 0; u + du < points.width(); ++u)
      if (const double distance = (points(u + du, v + dv) - points(u, v)).norm();
          std::isfinite(distance))
        distances.push_back(distance);
  return median(std::move(distances));
}

double rms_pixels(const GridSamples& samples, const RationalProjection& projection) {
  double squares = 0.0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const auto pixel = projection.project(samples.points[i]);
    if (!pixel) return std::numeric_limits<double>::infinity();
    squares += (*pixel - samples.pixels[i]).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, samples.points.size())));
}

}  // namespace relief
