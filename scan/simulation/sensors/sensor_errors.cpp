#include "scan/simulation/sensors/sensor_errors.h"

#include <cmath>

#include "scan/base/counter_random.h"
#include "scan/simulation/base/for_each_sample.h"
#include "scan/simulation/base/plane_waves.h"

namespace relief::simulation {

namespace {

Eigen::Vector3d rotated(const Eigen::Vector3d& normal, const Eigen::Vector3d& rotation) {
  const double angle = rotation.norm();
  if (angle == 0.0) return normal;
  return Eigen::AngleAxisd(angle, rotation / angle) * normal;
}

// The RMS angle by which rotations turn a view's normals; 0 without normals. To first order a
// rotation turns a normal by its part in the tangent plane. Row by row, in a fixed order.
double turn_rms(const RangeView& view, const Grid<Eigen::Vector3d>& rotations) {
  double squares = 0.0, count = 0.0;
  for_each_sample_in_order(view, [&](int u, int v) {
    if (!view.has_normal(u, v)) return;
    squares += rotations(u, v).cross(view.normals(u, v).cast<double>()).squaredNorm();
    count += 1.0;
  });
  return count == 0.0 ? 0.0 : std::sqrt(squares / count);
}

}  // namespace

Eigen::Vector3f facing_sensor(Eigen::Vector3d normal, const Eigen::Vector3d& ray_direction) {
  const Eigen::Vector3d viewing = ray_direction.normalized();
  // 89.94 degrees: just facing the sensor, far beyond the rounding of floats, 6e-8.
  constexpr double kLeastCosine = 1e-3;
  const double beyond = normal.dot(viewing) + kLeastCosine;
  if (beyond > 0.0) normal -= beyond * viewing;
  return normal.normalized().cast<float>();
}

// Equation (S2).
void add_range_noise(RangeView& view, double sigma, const RandomStream& stream, double right_half) {
  const CounterRandom random(stream.seed, stream.stream);
  for_each_sample(view, [&](int u, int v) {
    const double size = 2 * u >= view.width() ? right_half * sigma : sigma;
    view.range(u, v) +=
        size * random.normal(view.range.index(u, v)) / view.camera.ray(u, v).direction.norm();
  });
}

// Equation (S3), the white part.
void add_normal_noise(RangeView& view, double sigma_rad, const RandomStream& stream) {
  const CounterRandom random(stream.seed, stream.stream);
  for_each_normal(view, [&](int u, int v) {
    const std::size_t pixel = view.normals.index(u, v);
    const Eigen::Vector3d normal = view.normals[pixel].cast<double>();
    const Eigen::Vector3d across = normal.unitOrthogonal();
    const Eigen::Vector3d rotation =
        sigma_rad *
        (random.normal(2 * pixel) * across + random.normal(2 * pixel + 1) * normal.cross(across));
    view.normals[pixel] = facing_sensor(rotated(normal, rotation), view.camera.ray(u, v).direction);
  });
}

// Equation (S3), the smooth part.
void add_normal_bias(RangeView& view, double rms_rad, double wavelength,
                     const RandomStream& stream) {
  const PlaneWaves field(wavelength, CounterRandom(stream.seed, stream.stream));
  Grid<Eigen::Vector3d> rotations(view.width(), view.height(), Eigen::Vector3d::Zero());
  for_each_normal(view, [&](int u, int v) { rotations(u, v) = field.at(view.point(u, v)); });
  const double size = turn_rms(view, rotations);
  if (size == 0.0) return;
  for_each_normal(view, [&](int u, int v) {
    const Eigen::Vector3d rotation = rms_rad / size * rotations(u, v);
    view.normals(u, v) = facing_sensor(rotated(view.normals(u, v).cast<double>(), rotation),
                                       view.camera.ray(u, v).direction);
  });
}

RigidMotion random_motion(double angle_rad, double distance, const Eigen::Vector3d& centre,
                          const RandomStream& stream) {
  const CounterRandom random(stream.seed, stream.stream);
  const Eigen::AngleAxisd rotation(angle_rad, random_direction(random, 0));
  const Eigen::Vector3d translation = distance * random_direction(random, 3);
  return Eigen::Translation3d(centre + translation) * rotation * Eigen::Translation3d(-centre);
}

}  // namespace relief::simulation
