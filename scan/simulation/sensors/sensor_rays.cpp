#include "relief/simulation/sensor_rays.h"

#include <utility>

namespace relief::simulation {

namespace {

Camera line_camera(int width, int height, double focal, double spacing) {
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  Grid<Ray> rays(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      rays(u, v) = {{spacing * (u - cx), 0.0, 0.0}, {0.0, (v - cy) / focal, 1.0}};
  RationalProjection projection;
  projection.u_numerator = {1.0 / spacing, 0.0, 0.0, cx};
  projection.u_denominator = {0.0, 0.0, 0.0, 1.0};
  projection.v_numerator = {0.0, focal, cy, 0.0};
  projection.v_denominator = {0.0, 0.0, 1.0, 0.0};
  return Camera::ray_table(std::move(rays), projection);
}

}  // namespace

Camera sensor_camera(SensorRays rays, int width, int height, double focal, double spacing) {
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  switch (rays) {
    case SensorRays::kPinhole:
      return Camera::pinhole(width, height, {focal, focal, cx, cy});
    case SensorRays::kOrthographic:
      return Camera::orthographic(width, height, {-spacing * cx, -spacing * cy, 0.0},
                                  {spacing, 0.0, 0.0}, {0.0, spacing, 0.0},
                                  Eigen::Vector3d::UnitZ());
    case SensorRays::kLine:
      return line_camera(width, height, focal, spacing);
  }
  return {};
}

}  // namespace relief::simulation
