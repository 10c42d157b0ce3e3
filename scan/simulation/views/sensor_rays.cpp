#include "scan/simulation/views/sensor_rays.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "relief/simulation/simulate.h"

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

// Columns run clockwise as seen from above, rows downwards, as in a picture from inside.
Camera spherical_camera(int width, int height) {
  const double step = 2.0 * std::numbers::pi / width;
  const double elevation_step = std::min(step, std::numbers::pi / height);
  return Camera::spherical(SphericalProjection::even(width, height, 0.5 * (width - 1) * step, -step,
                                                     0.5 * (height - 1) * elevation_step,
                                                     -elevation_step));
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
    case SensorRays::kSpherical:
      return spherical_camera(width, height);
  }
  return {};
}

RigidMotion optical_from_sensor(SensorRays rays) {
  RigidMotion motion = RigidMotion::Identity();
  if (rays == SensorRays::kSpherical) motion.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return motion;
}

}  // namespace relief::simulation
