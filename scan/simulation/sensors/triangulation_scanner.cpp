#include "scan/simulation/sensors/triangulation_scanner.h"

#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "relief/simulation/range_sensors.h"
#include "scan/simulation/base/for_each_sample.h"
#include "scan/simulation/base/option_check.h"
#include "scan/simulation/defects/calibration_warp.h"
#include "scan/simulation/objects/in_sight.h"
#include "scan/simulation/sensors/edge_mixer.h"
#include "scan/simulation/sensors/pixel_noise.h"

namespace relief::simulation {

namespace {

// f b of equation (S5) [pixels x unit].
double disparity_scale(const TriangulationScanner& scanner, const SensorScene& scene) {
  return scene.distance / scene.spacing * scanner.baseline * scene.distance;
}

// What comes back of the second ray's light.
class Illumination {
 public:
  Illumination(const TriangulationScanner& scanner, const SensorScene& scene)
      : scanner_(scanner),
        scene_(scene),
        noise_(pixel_noise(scene.truth.width(), scene.truth.height(), scanner.noise_correlation,
                           scene.of_view(kSignalNoise))) {}

  // The signal of a pixel; nothing where the second ray does not reach the point or too little or
  // too much of its light comes back: equation (S7).
  std::optional<double> signal(int u, int v) const {
    const Ray ray = scene_.truth.camera.ray(u, v);
    const Eigen::Vector3d point = ray.at(scene_.truth.range(u, v));
    const Eigen::Vector3d normal = scene_.truth.normals(u, v).cast<double>();
    const Eigen::Vector3d projector =
        ray.origin + scanner_.baseline * scene_.distance * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d to_camera = -ray.direction.normalized();
    const Eigen::Vector3d to_projector = (projector - point).normalized();
    const double lit = normal.dot(to_projector);
    if (lit <= 0.0) return std::nullopt;
    const Eigen::Vector3d world_point = scene_.truth.world_from_view * point;
    const SurfacePaint paint = scene_.paint_at(u, v, world_point);
    const double noise = scanner_.signal_noise * noise_(u, v);
    const double signal = paint.albedo * lit * normal.dot(to_camera) + noise;
    if (signal < scanner_.least_signal || signal <= 0.0) return std::nullopt;
    const double light = scene_.paint.reflected(paint, normal, to_projector, to_camera);
    if (light + noise > scanner_.saturation) return std::nullopt;
    if (!in_sight(scene_.object, scene_.truth.world_from_view * projector, world_point))
      return std::nullopt;
    return signal;
  }

 private:
  const TriangulationScanner& scanner_;
  const SensorScene& scene_;
  Grid<double> noise_;
};

// The depth that a pixel sees, mixed across an occlusion edge: equation (S8).
double mixed_depth(double own, const EdgeMixer::Mixture& mixture) {
  if (mixture.share == 0.0) return own;
  return 1.0 / ((1.0 - mixture.share) / own + mixture.share / mixture.other);
}

double rounded_to(double value, double step) {
  return step > 0.0 ? step * std::round(value / step) : value;
}

}  // namespace

TriangulationScanner structured_light_scanner() { return {}; }

TriangulationScanner laser_line_scanner() {
  TriangulationScanner scanner;
  scanner.baseline = 0.5;
  scanner.disparity_noise = 0.15;
  scanner.noise_correlation = 3.0;
  scanner.disparity_step = 1.0 / 16.0;
  scanner.flying_fraction = 0.6;
  return scanner;
}

TriangulationScanner rgbd_camera() {
  TriangulationScanner scanner;
  scanner.baseline = 0.075;
  scanner.disparity_noise = 0.06;
  scanner.noise_growth = 1.0;
  scanner.noise_correlation = 3.0;
  scanner.disparity_step = 1.0 / 8.0;
  scanner.flying_fraction = 0.5;
  scanner.warp = 1.0;
  return scanner;
}

Result<void> validate(const TriangulationScanner& s) {
  return first_failure({require_positive("baseline", s.baseline),
                        require_not_negative("disparity_noise", s.disparity_noise),
                        require(s.noise_growth >= 0.0 && s.noise_growth <= 2.0, "noise_growth",
                                s.noise_growth, "in [0, 2]"),
                        require(s.noise_correlation >= 0.0 && s.noise_correlation <= 100.0,
                                "noise_correlation", s.noise_correlation, "in [0, 100] pixels"),
                        require_not_negative("disparity_step", s.disparity_step),
                        require_not_negative("least_signal", s.least_signal),
                        require_positive("saturation", s.saturation),
                        require_not_negative("signal_noise", s.signal_noise),
                        require(s.flying_fraction >= 0.0 && s.flying_fraction <= 1.0,
                                "flying_fraction", s.flying_fraction, "in [0, 1]"),
                        require_not_negative("warp", s.warp)});
}

void scan_by_triangulation(RangeView& view, const TriangulationScanner& scanner,
                           const SensorScene& scene) {
  const Illumination illumination(scanner, scene);
  const EdgeMixer edges(scanner.flying_fraction, scene);
  const Grid<double> noise = pixel_noise(view.width(), view.height(), scanner.noise_correlation,
                                         scene.of_view(kDisparityNoise));
  const CalibrationWarp warp(scene.of_sensor(kCalibrationWarp));
  const double scale = disparity_scale(scanner, scene);
  for_each_sample(scene.truth, [&](int u, int v) {
    const auto signal = illumination.signal(u, v);
    if (!signal) return lose_sample(view, u, v);
    // Equations (S5) and (S6).
    const double deviation =
        scanner.disparity_noise * std::pow(*signal, -scanner.noise_growth) * scene.noise_factor(u);
    const double measured = rounded_to(
        scale / mixed_depth(scene.truth.range(u, v), edges.at(u, v)) + deviation * noise(u, v),
        scanner.disparity_step);
    if (!(measured > 0.0)) return lose_sample(view, u, v);
    view.range(u, v) = scale / measured + scanner.warp * scene.spacing *
                                              warp.at(image_coordinate(u, view.width()),
                                                      image_coordinate(v, view.height()));
  });
}

double depth_deviation(const TriangulationScanner& scanner, double z, double distance,
                       double spacing) {
  return z * z * spacing / (distance * distance * scanner.baseline) * scanner.disparity_noise;
}

}  // namespace relief::simulation
