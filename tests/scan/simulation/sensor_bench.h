#pragma once

#include "relief/simulation/simulate.h"
#include "relief/simulation/simulation_object.h"
#include "scan/simulation/objects/reflectance.h"
#include "scan/simulation/sensors/sensor_scene.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::testing {

/// A surface before a sensor, and what its models need to know.
struct SensorBench {
  explicit SensorBench(const Surface& surface, const Camera& sensor = default_camera(),
                       const simulation::Reflectance& reflectance = {},
                       const RigidMotion& world_from_view = RigidMotion::Identity())
      : paint(reflectance, kDiameter, simulation::sensor_stream(1, simulation::kDarkPatches),
              simulation::sensor_stream(1, simulation::kGlossyPatches)) {
    object.radius = 0.5 * kDiameter;
    object.cast = [surface](const Ray& ray) -> std::optional<simulation::SurfaceHit> {
      const auto hit = surface(ray);
      if (!hit) return std::nullopt;
      return simulation::SurfaceHit{hit->t, hit->normal};
    };
    truth = simulation::exact_view(object, sensor, world_from_view, 89.9);
  }

  /// Pixels of side 0.02 at the working distance.
  static Camera default_camera() { return Camera::pinhole(320, 240, {500, 500, 159.5, 119.5}); }

  simulation::SensorScene scene(int view = 0) const {
    return {object, paint, truth, view, kDistance, kDistance / 500.0, kDiameter, 1};
  }

  static constexpr double kDistance = 10.0, kDiameter = 4.0;
  simulation::SimulationObject object;
  simulation::PaintedSurface paint;
  RangeView truth;
};

/// A triangulation scanner without any error.
inline simulation::TriangulationScanner perfect_scanner() {
  simulation::TriangulationScanner scanner;
  scanner.disparity_noise = scanner.disparity_step = scanner.signal_noise = 0.0;
  scanner.flying_fraction = scanner.warp = scanner.least_signal = 0.0;
  scanner.noise_growth = 0.0;
  scanner.saturation = 1e9;
  return scanner;
}

/// A photometric-stereo camera without any error but shadows left out.
inline simulation::PhotometricStereo perfect_shading() {
  simulation::PhotometricStereo camera;
  camera.noise_deg = camera.distortion_deg = camera.bias_deg = 0.0;
  camera.interreflection = 0.0;
  camera.shadow_threshold = 1e-9;
  return camera;
}

inline double angle_between(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3d x = a.cast<double>(), y = b.cast<double>();
  return std::atan2(x.cross(y).norm(), x.dot(y));
}

}  // namespace relief::testing
