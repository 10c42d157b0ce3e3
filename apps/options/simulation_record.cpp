#include "apps/options/simulation_record.h"

#include <variant>

namespace relief {

namespace {

const char* name_of(simulation::SensorRays rays) {
  switch (rays) {
    case simulation::SensorRays::kPinhole:
      return "pinhole";
    case simulation::SensorRays::kOrthographic:
      return "orthographic";
    case simulation::SensorRays::kLine:
      return "line";
    case simulation::SensorRays::kSpherical:
      return "spherical";
  }
  return "";
}

Json to_json(const simulation::WhiteRangeSensor& sensor) {
  return {{"model", "white"}, {"noise", sensor.noise}};
}

Json to_json(const simulation::TriangulationScanner& sensor) {
  return {{"model", "triangulation"},
          {"baseline", sensor.baseline},
          {"disparity_noise", sensor.disparity_noise},
          {"noise_growth", sensor.noise_growth},
          {"noise_correlation", sensor.noise_correlation},
          {"disparity_step", sensor.disparity_step},
          {"least_signal", sensor.least_signal},
          {"saturation", sensor.saturation},
          {"signal_noise", sensor.signal_noise},
          {"flying_fraction", sensor.flying_fraction},
          {"warp", sensor.warp}};
}

Json to_json(const simulation::TimeOfFlightCamera& sensor) {
  return {{"model", "time of flight"},
          {"noise", sensor.noise},
          {"noise_growth", sensor.noise_growth},
          {"least_amplitude", sensor.least_amplitude},
          {"flying_fraction", sensor.flying_fraction},
          {"multipath", sensor.multipath},
          {"multipath_wavelength", sensor.multipath_wavelength},
          {"range_step", sensor.range_step}};
}

Json to_json(const simulation::WhiteNormalSensor& sensor) {
  return {{"model", "white"},
          {"noise_deg", sensor.noise_deg},
          {"bias_deg", sensor.bias_deg},
          {"bias_wavelength", sensor.bias_wavelength}};
}

Json to_json(const simulation::PhotometricStereo& sensor) {
  return {{"model", "photometric stereo"},
          {"lights", sensor.lights},
          {"light_angle_deg", sensor.light_angle_deg},
          {"noise_deg", sensor.noise_deg},
          {"distortion_deg", sensor.distortion_deg},
          {"bias_deg", sensor.bias_deg},
          {"bias_wavelength", sensor.bias_wavelength},
          {"interreflection", sensor.interreflection},
          {"shadow_threshold", sensor.shadow_threshold}};
}

Json to_json(const simulation::NoNormalSensor&) { return {{"model", "none"}}; }

Json to_json(const simulation::Reflectance& reflectance) {
  return {{"dark_fraction", reflectance.dark_fraction},
          {"dark_albedo", reflectance.dark_albedo},
          {"glossy_fraction", reflectance.glossy_fraction},
          {"patch_size", reflectance.patch_size},
          {"highlight_width_deg", reflectance.highlight_width_deg},
          {"highlight_strength", reflectance.highlight_strength}};
}

template <typename... Sensors>
Json sensor_json(const std::variant<Sensors...>& sensor) {
  return std::visit([](const auto& s) { return to_json(s); }, sensor);
}

}  // namespace

Json simulation_record(const simulation::Simulation& simulation,
                       const simulation::SimulationOptions& options) {
  return {{"seed", options.seed},
          {"unit", simulation.scans.unit},
          {"diameter", simulation.diameter},
          {"working_distance", simulation.distance},
          {"sample_spacing", simulation.spacing},
          {"range_sigma", simulation.range_sigma},
          {"rays", name_of(options.rays)},
          {"max_incidence_deg", options.max_incidence_deg},
          {"range_sensor", sensor_json(options.range_sensor)},
          {"normal_sensor", sensor_json(options.normal_sensor)},
          {"reflectance", to_json(options.reflectance)},
          {"pose_rotation_deg", options.pose_rotation_deg},
          {"pose_translation", options.pose_translation}};
}

}  // namespace relief
