#include "scan/simulation/sensors/sensors.h"

#include "scan/simulation/base/degrees.h"
#include "scan/simulation/base/option_check.h"
#include "scan/simulation/sensors/photometric_stereo.h"
#include "scan/simulation/sensors/sensor_errors.h"
#include "scan/simulation/sensors/time_of_flight.h"
#include "scan/simulation/sensors/triangulation_scanner.h"

namespace relief::simulation {

namespace {

// The random streams of the white sensors.
enum Stream : std::uint64_t { kRangeNoise, kNormalNoise, kNormalBias };

RandomStream stream_of(const SensorScene& scene, Stream stream) {
  return {scene.seed, static_cast<std::uint64_t>(scene.view) * 4 + stream};
}

Result<void> validate(const WhiteRangeSensor& sensor) {
  return require_not_negative("range noise", sensor.noise);
}

Result<void> validate(const WhiteNormalSensor& sensor) {
  return first_failure({require_not_negative("normal noise_deg", sensor.noise_deg),
                        require_not_negative("normal bias_deg", sensor.bias_deg),
                        require_positive("normal bias_wavelength", sensor.bias_wavelength)});
}

Result<void> validate(const NoNormalSensor&) { return {}; }

void measure(RangeView& view, const WhiteRangeSensor& sensor, const SensorScene& scene) {
  if (sensor.noise > 0.0)
    add_range_noise(view, sensor.noise * scene.spacing, stream_of(scene, kRangeNoise),
                    scene.noise_half);
}

void measure(RangeView& view, const TriangulationScanner& sensor, const SensorScene& scene) {
  scan_by_triangulation(view, sensor, scene);
}

void measure(RangeView& view, const TimeOfFlightCamera& sensor, const SensorScene& scene) {
  scan_by_time_of_flight(view, sensor, scene);
}

double deviation(const WhiteRangeSensor& sensor, double, double spacing) {
  return sensor.noise * spacing;
}

double deviation(const TriangulationScanner& sensor, double distance, double spacing) {
  return depth_deviation(sensor, distance, distance, spacing);
}

double deviation(const TimeOfFlightCamera& sensor, double, double spacing) {
  return sensor.noise * spacing;
}

// The bias belongs to the surface, the noise to the single sample: bias first.
void measure(RangeView& view, const WhiteNormalSensor& sensor, const SensorScene& scene) {
  if (sensor.bias_deg > 0.0)
    add_normal_bias(view, radians(sensor.bias_deg), sensor.bias_wavelength * scene.diameter,
                    stream_of(scene, kNormalBias));
  if (sensor.noise_deg > 0.0)
    add_normal_noise(view, radians(sensor.noise_deg), stream_of(scene, kNormalNoise));
}

void measure(RangeView& view, const PhotometricStereo& sensor, const SensorScene& scene) {
  scan_by_shading(view, sensor, scene);
}

void measure(RangeView& view, const NoNormalSensor&, const SensorScene&) { view.normals = {}; }

}  // namespace

Result<void> validate(const RangeSensor& sensor) {
  return std::visit([](const auto& s) { return validate(s); }, sensor);
}

Result<void> validate(const NormalSensor& sensor) {
  return std::visit([](const auto& s) { return validate(s); }, sensor);
}

double range_deviation(const RangeSensor& sensor, double distance, double spacing) {
  return std::visit([&](const auto& s) { return deviation(s, distance, spacing); }, sensor);
}

void measure_normals(RangeView& view, const NormalSensor& sensor, const SensorScene& scene) {
  std::visit([&](const auto& s) { measure(view, s, scene); }, sensor);
}

void measure_range(RangeView& view, const RangeSensor& sensor, const SensorScene& scene) {
  std::visit([&](const auto& s) { measure(view, s, scene); }, sensor);
}

}  // namespace relief::simulation
