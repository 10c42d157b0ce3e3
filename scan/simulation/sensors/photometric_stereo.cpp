#include "scan/simulation/sensors/photometric_stereo.h"

#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Dense>

#include "relief/simulation/normal_sensors.h"
#include "scan/base/counter_random.h"
#include "scan/simulation/base/degrees.h"
#include "scan/simulation/base/for_each_sample.h"
#include "scan/simulation/base/option_check.h"
#include "scan/simulation/objects/in_sight.h"
#include "scan/simulation/sensors/sensor_errors.h"

namespace relief::simulation {

namespace {

constexpr int kMostLights = 64;  // Bounds the memory of a pixel.
// One number per light, without allocation.
using PerLight = Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostLights, 1>;

// The reading noise that gives `noise_deg` on a frontal white surface: there the least-squares
// solution has the covariance sigma^2 (L^T L)^-1 with the tangential entries of L^T L being
// lights / 2 sin^2 angle.
double reading_deviation(const PhotometricStereo& camera) {
  return radians(camera.noise_deg) * std::sin(radians(camera.light_angle_deg)) *
         std::sqrt(0.5 * camera.lights);
}

// Brightness of each pixel under each light: equation (S11).
class Readings {
 public:
  Readings(const PhotometricStereo& camera, const SensorScene& scene)
      : camera_(camera),
        scene_(scene),
        lights_(light_directions(camera)),
        deviation_(reading_deviation(camera)),
        random_(scene.of_view(kReadingNoise).seed, scene.of_view(kReadingNoise).stream) {}

  PerLight at(int u, int v) const {
    const Ray ray = scene_.truth.camera.ray(u, v);
    const Eigen::Vector3d normal = scene_.truth.normals(u, v).cast<double>();
    const Eigen::Vector3d to_camera = -ray.direction.normalized();
    const RigidMotion& world_from_view = scene_.truth.world_from_view;
    const Eigen::Vector3d point = world_from_view * ray.at(scene_.truth.range(u, v));
    const SurfacePaint paint = scene_.paint_at(u, v, point);
    const std::size_t first = scene_.truth.range.index(u, v) * lights_.size();
    PerLight brightness(lights_.size());
    for (std::size_t k = 0; k < lights_.size(); ++k) {
      const bool lit = normal.dot(lights_[k]) > 0.0 &&
                       in_sight(scene_.object, light_place(u, v, point, lights_[k]), point);
      const double light = lit ? scene_.paint.reflected(paint, normal, lights_[k], to_camera)
                               : camera_.interreflection * paint.albedo;
      brightness[static_cast<Eigen::Index>(k)] = light + deviation_ * random_.normal(first + k);
    }
    return brightness;
  }

 private:
  // A place towards a light that is outside the object.
  Eigen::Vector3d light_place(int u, int v, const Eigen::Vector3d& point,
                              const Eigen::Vector3d& light) const {
    double distance = 1.01 * scene_.diameter;
    if (scene_.sees_background(u, v))
      distance = (point - scene_.object.centre).norm() + 1.01 * scene_.object.radius;
    return point + distance * (scene_.truth.world_from_view.linear() * light);
  }

  const PhotometricStereo& camera_;
  const SensorScene& scene_;
  std::vector<Eigen::Vector3d> lights_;
  double deviation_;
  CounterRandom random_;
};

// Least squares over the lights not in shadow: equation (S12).
std::optional<Eigen::Vector3d> solve_normal(const std::vector<Eigen::Vector3d>& lights,
                                            const PerLight& brightness, double threshold) {
  const double least = threshold * brightness.maxCoeff();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  int used = 0;
  for (std::size_t k = 0; k < lights.size(); ++k) {
    const double reading = brightness[static_cast<Eigen::Index>(k)];
    if (reading < least) continue;
    squares += lights[k] * lights[k].transpose();
    right_side += reading * lights[k];
    ++used;
  }
  if (used < 3) return std::nullopt;
  const Eigen::Vector3d solution = squares.inverse() * right_side;
  if (!solution.allFinite() || solution.norm() == 0.0) return std::nullopt;
  return solution.normalized();
}

}  // namespace

Result<void> validate(const PhotometricStereo& c) {
  const auto share = [](double x) { return x >= 0.0 && x <= 1.0; };
  return first_failure(
      {require(c.lights >= 3 && c.lights <= kMostLights, "lights", c.lights, "in [3, 64]"),
       require(c.light_angle_deg > 0.0 && c.light_angle_deg < 90.0, "light_angle_deg",
               c.light_angle_deg, "in (0, 90)"),
       require_not_negative("noise_deg", c.noise_deg),
       require(c.distortion_deg >= 0.0 && c.distortion_deg <= 30.0, "distortion_deg",
               c.distortion_deg, "in [0, 30]"),
       require_not_negative("bias_deg", c.bias_deg),
       require_positive("bias_wavelength", c.bias_wavelength),
       require(share(c.interreflection), "interreflection", c.interreflection, "in [0, 1]"),
       require(c.shadow_threshold >= 0.0 && c.shadow_threshold < 1.0, "shadow_threshold",
               c.shadow_threshold, "in [0, 1)")});
}

std::vector<Eigen::Vector3d> light_directions(const PhotometricStereo& camera) {
  const double angle = radians(camera.light_angle_deg);
  std::vector<Eigen::Vector3d> lights;
  for (int k = 0; k < camera.lights; ++k) {
    const double turn = 2.0 * std::numbers::pi * (k + 0.5) / camera.lights;
    lights.emplace_back(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn),
                        -std::cos(angle));
  }
  return lights;
}

// With mean values over the sphere, |E n|^2 -> tr(E^T E) / 3 and
// (n^T E n)^2 -> (tr(E)^2 + tr(E E) + tr(E^T E)) / 15, so the angle has the mean square below.
Eigen::Matrix3d normal_distortion(const PhotometricStereo& camera, const RandomStream& stream) {
  const CounterRandom random(stream.seed, stream.stream);
  Eigen::Matrix3d error;
  for (Eigen::Index i = 0; i < 9; ++i) error(i) = random.normal(static_cast<std::uint64_t>(i));
  const double own = error.squaredNorm();
  const double along = error.trace() * error.trace() + (error * error).trace() + own;
  const double mean_square = own / 3.0 - along / 15.0;
  return Eigen::Matrix3d::Identity() +
         radians(camera.distortion_deg) / std::sqrt(mean_square) * error;
}

// Readings L n solved with believed lights B = L A^-1 give B^+ L n = A n: the light l is believed
// to be A^-T l.
void scan_by_shading(RangeView& view, const PhotometricStereo& camera, const SensorScene& scene) {
  const Readings readings(camera, scene);
  const Eigen::Matrix3d unbelieved =
      normal_distortion(camera, scene.of_sensor(kNormalDistortion)).inverse().transpose();
  std::vector<Eigen::Vector3d> believed = light_directions(camera);
  for (Eigen::Vector3d& light : believed) light = unbelieved * light;
  for_each_sample(scene.truth, [&](int u, int v) {
    const auto normal = solve_normal(believed, readings.at(u, v), camera.shadow_threshold);
    view.normals(u, v) = normal ? facing_sensor(*normal, view.camera.ray(u, v).direction)
                                : Eigen::Vector3f::Constant(static_cast<float>(kNoSample));
  });
  add_normal_bias(view, radians(camera.bias_deg), camera.bias_wavelength * scene.diameter,
                  scene.of_view(kPhotometricBias));
}

}  // namespace relief::simulation
