#include "scan/simulation/sensors/time_of_flight.h"

#include <cmath>

#include "relief/simulation/range_sensors.h"
#include "scan/base/counter_random.h"
#include "scan/simulation/base/for_each_sample.h"
#include "scan/simulation/base/option_check.h"
#include "scan/simulation/base/plane_waves.h"
#include "scan/simulation/sensors/edge_mixer.h"

namespace relief::simulation {

namespace {

CounterRandom random_of(const RandomStream& stream) { return {stream.seed, stream.stream}; }

// Equation (S14).
double amplitude(const SensorScene& scene, int u, int v) {
  const RangeView& truth = scene.truth;
  const Ray ray = truth.camera.ray(u, v);
  const Eigen::Vector3d point = ray.at(truth.range(u, v));
  const double cosine = -truth.normals(u, v).cast<double>().dot(ray.direction.normalized());
  const double albedo = scene.paint_at(u, v, truth.world_from_view * point).albedo;
  const double fall = scene.distance / truth.range(u, v);
  return albedo * cosine * fall * fall;
}

// Light that went a longer way, [unit]: the square of a smooth field, scaled to its RMS.
Grid<double> multipath(const TimeOfFlightCamera& camera, const SensorScene& scene) {
  const RangeView& truth = scene.truth;
  const PlaneWaves waves(camera.multipath_wavelength * scene.diameter,
                         random_of(scene.of_view(kMultipath)));
  Grid<double> error(truth.width(), truth.height(), 0.0);
  for_each_sample(truth, [&](int u, int v) {
    const double wave = waves.scalar_at(truth.point(u, v));
    error(u, v) = wave * wave;
  });
  double squares = 0.0, count = 0.0;
  for_each_sample_in_order(truth, [&](int u, int v) {
    squares += error(u, v) * error(u, v);
    count += 1.0;
  });
  const double scale =
      squares > 0.0 ? camera.multipath * scene.spacing / std::sqrt(squares / count) : 0.0;
  for (double& value : error) value *= scale;
  return error;
}

}  // namespace

Result<void> validate(const TimeOfFlightCamera& c) {
  return first_failure({require_not_negative("noise", c.noise),
                        require(c.noise_growth >= 0.0 && c.noise_growth <= 2.0, "noise_growth",
                                c.noise_growth, "in [0, 2]"),
                        require_not_negative("least_amplitude", c.least_amplitude),
                        require(c.flying_fraction >= 0.0 && c.flying_fraction <= 1.0,
                                "flying_fraction", c.flying_fraction, "in [0, 1]"),
                        require_not_negative("multipath", c.multipath),
                        require_positive("multipath_wavelength", c.multipath_wavelength),
                        require_not_negative("range_step", c.range_step)});
}

void scan_by_time_of_flight(RangeView& view, const TimeOfFlightCamera& camera,
                            const SensorScene& scene) {
  const EdgeMixer edges(camera.flying_fraction, scene);
  const Grid<double> longer = multipath(camera, scene);
  const CounterRandom random = random_of(scene.of_view(kFlightNoise));
  const double step = camera.range_step * scene.spacing;
  for_each_sample(scene.truth, [&](int u, int v) {
    const double signal = amplitude(scene, u, v);
    if (signal < camera.least_amplitude || signal <= 0.0) return lose_sample(view, u, v);
    // Equation (S15).
    const EdgeMixer::Mixture mixture = edges.at(u, v);
    const double deviation = camera.noise * scene.spacing * scene.noise_factor(u) *
                             std::pow(signal, -camera.noise_growth);
    double range = scene.truth.range(u, v);
    range += mixture.share * (mixture.other - range) + longer(u, v) +
             deviation * random.normal(view.range.index(u, v));
    if (step > 0.0) range = step * std::round(range / step);
    if (!(range > 0.0)) return lose_sample(view, u, v);
    view.range(u, v) = range;
  });
}

}  // namespace relief::simulation
