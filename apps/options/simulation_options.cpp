#include "apps/options/simulation_options.h"

#include <map>
#include <utility>
#include <variant>

#include "apps/options/number_checks.h"

namespace relief {

namespace {

const std::map<std::string, PoseKind> kPoses = {
    {"exact", PoseKind::kKnown}, {"perturbed", PoseKind::kGuess}, {"absent", PoseKind::kAbsent}};
const std::map<std::string, simulation::ViewLayout> kLayouts = {
    {"turntable", simulation::ViewLayout::kTurntable}, {"sphere", simulation::ViewLayout::kSphere}};
const std::map<std::string, simulation::SensorRays> kRays = {
    {"pinhole", simulation::SensorRays::kPinhole},
    {"orthographic", simulation::SensorRays::kOrthographic},
    {"line", simulation::SensorRays::kLine},
    {"spherical", simulation::SensorRays::kSpherical}};
const std::map<std::string, simulation::RangeSensor> kRangeSensors = {
    {"exact", simulation::WhiteRangeSensor{0.0}},
    {"white", simulation::WhiteRangeSensor{}},
    {"structured-light", simulation::structured_light_scanner()},
    {"laser-line", simulation::laser_line_scanner()},
    {"rgbd", simulation::rgbd_camera()},
    {"tof", simulation::TimeOfFlightCamera{}}};
const std::map<std::string, simulation::NormalSensor> kNormalSensors = {
    {"exact", simulation::WhiteNormalSensor{0.0, 0.0}},
    {"white", simulation::WhiteNormalSensor{}},
    {"photometric-stereo", simulation::PhotometricStereo{}},
    {"none", simulation::NoNormalSensor{}}};

template <typename Sensor>
std::vector<std::string> names_of(const std::map<std::string, Sensor>& sensors) {
  std::vector<std::string> names;
  for (const auto& [name, sensor] : sensors) names.push_back(name);
  return names;
}

// A sensor that looks at the surface's colour comes with a surface that has some.
bool looks_at_reflectance(const simulation::SimulationOptions& options) {
  return !std::holds_alternative<simulation::WhiteRangeSensor>(options.range_sensor) ||
         std::holds_alternative<simulation::PhotometricStereo>(options.normal_sensor);
}

// One parameter of a command line: sets the field of the chosen sensor, wherever it is found.
class ParameterAdder {
 public:
  ParameterAdder(CLI::App& command, SensorChoice& choice, const char* group)
      : command_(command), choice_(choice), group_(group) {}

  template <typename Value>
  void add(const char* name, const char* help,
           std::function<Value*(simulation::SimulationOptions&)> field, const char* needs) {
    command_
        .add_option_function<Value>(
            name,
            [this_choice = &choice_, name, field = std::move(field), needs](const Value& value) {
              this_choice->overrides.push_back(
                  [=](simulation::SimulationOptions& options) -> Result<void> {
                    Value* target = field(options);
                    if (!target)
                      return Error{ErrorKind::kBadInput,
                                   std::string(name) + " has no meaning here; it needs " + needs};
                    *target = value;
                    return {};
                  });
            },
            help)
        ->group(group_);
  }

 private:
  CLI::App& command_;
  SensorChoice& choice_;
  const char* group_;
};

template <typename Value>
using Field = std::function<Value*(simulation::SimulationOptions&)>;

// The member of the chosen sensor, null when another kind is chosen.
template <typename Sensor, typename Value>
Field<Value> of_range(Value Sensor::*member) {
  return [member](simulation::SimulationOptions& options) -> Value* {
    auto* sensor = std::get_if<Sensor>(&options.range_sensor);
    return sensor ? &(sensor->*member) : nullptr;
  };
}

template <typename Sensor, typename Value>
Field<Value> of_normal(Value Sensor::*member) {
  return [member](simulation::SimulationOptions& options) -> Value* {
    auto* sensor = std::get_if<Sensor>(&options.normal_sensor);
    return sensor ? &(sensor->*member) : nullptr;
  };
}

// Of a parameter that two range sensors have.
template <typename First, typename Second>
Field<double> of_ranges(double First::*first, double Second::*second) {
  return
      [first = of_range(first), second = of_range(second)](simulation::SimulationOptions& options) {
        double* field = first(options);
        return field ? field : second(options);
      };
}

// Of a parameter that both normal sensors have.
Field<double> of_either(double simulation::WhiteNormalSensor::*white,
                        double simulation::PhotometricStereo::*shading) {
  return [white = of_normal(white),
          shading = of_normal(shading)](simulation::SimulationOptions& options) {
    double* field = white(options);
    return field ? field : shading(options);
  };
}

Field<double> of_surface(double simulation::Reflectance::*member) {
  return [member](simulation::SimulationOptions& options) -> double* {
    return looks_at_reflectance(options) ? &(options.reflectance.*member) : nullptr;
  };
}

void add_triangulation_parameters(ParameterAdder& parameters) {
  const auto add = [&](const char* name, const char* help,
                       double simulation::TriangulationScanner::*member) {
    parameters.add<double>(name, help, of_range(member),
                           "--range-sensor structured-light, laser-line or rgbd");
  };
  using T = simulation::TriangulationScanner;
  add("--baseline", "From the camera to the projector or laser [working distances]", &T::baseline);
  add("--disparity-noise", "Standard deviation of the disparity [pixels]", &T::disparity_noise);
  add("--noise-correlation", "Distance at which its correlation is 1/e [pixels]",
      &T::noise_correlation);
  add("--disparity-step", "Step of the disparity [pixels]; 0: none", &T::disparity_step);
  add("--saturation", "Samples with more light are lost [that of white, frontal]", &T::saturation);
  add("--signal-noise", "Noise of signal and light, standard deviation", &T::signal_noise);
  add("--warp", "Smooth error of the calibration, RMS over the image [sample spacings]", &T::warp);
}

void add_range_parameters(CLI::App& command, SensorChoice& choice) {
  ParameterAdder parameters(command, choice, "Range sensor");
  using W = simulation::WhiteRangeSensor;
  using T = simulation::TriangulationScanner;
  using F = simulation::TimeOfFlightCamera;
  parameters.add<double>("--range-noise",
                         "White noise: standard deviation along the ray [sample spacings]",
                         of_ranges(&W::noise, &F::noise), "--range-sensor white, exact or tof");
  add_triangulation_parameters(parameters);
  const char* const lit = "--range-sensor structured-light, laser-line, rgbd or tof";
  parameters.add<double>("--noise-growth",
                         "Exponent p: with less signal the noise grows as signal^-p",
                         of_ranges(&T::noise_growth, &F::noise_growth), lit);
  parameters.add<double>("--least-signal",
                         "Samples with less signal are lost [that of white, frontal]",
                         of_ranges(&T::least_signal, &F::least_amplitude), lit);
  parameters.add<double>(
      "--flying", "Part of the samples beside occlusion edges that lie between the two sides",
      of_ranges(&T::flying_fraction, &F::flying_fraction), lit);
  const char* const flight = "--range-sensor tof";
  parameters.add<double>("--multipath",
                         "Smooth error by light on longer ways, RMS over a view [sample spacings]",
                         of_range(&F::multipath), flight);
  parameters.add<double>("--multipath-wavelength", "Its shortest wave length [diameters]",
                         of_range(&F::multipath_wavelength), flight);
  parameters.add<double>("--range-step", "Step of the range [sample spacings]; 0: none",
                         of_range(&F::range_step), flight);
}

void add_normal_parameters(CLI::App& command, SensorChoice& choice) {
  ParameterAdder parameters(command, choice, "Normal sensor");
  using W = simulation::WhiteNormalSensor;
  using P = simulation::PhotometricStereo;
  const char* const some = "--normal-sensor white, photometric-stereo or exact";
  const char* const shading = "--normal-sensor photometric-stereo";
  parameters.add<double>("--normal-noise", "White noise about each tangent axis [deg]",
                         of_either(&W::noise_deg, &P::noise_deg), some);
  parameters.add<double>("--normal-bias", "Smooth error, RMS of its angle over each view [deg]",
                         of_either(&W::bias_deg, &P::bias_deg), some);
  parameters.add<double>("--normal-bias-wavelength",
                         "Shortest wave length of the smooth error [diameters]",
                         of_either(&W::bias_wavelength, &P::bias_wavelength), some);
  parameters.add<double>("--normal-distortion",
                         "Linear distortion of the normals, RMS of its angle [deg]",
                         of_normal(&P::distortion_deg), shading);
  parameters.add<int>("--lights", "Number of lights", of_normal(&P::lights), shading);
  parameters.add<double>("--light-angle", "Between the lights and the viewing axis [deg]",
                         of_normal(&P::light_angle_deg), shading);
  parameters.add<double>("--interreflection", "Reading of a light in shadow [of the albedo]",
                         of_normal(&P::interreflection), shading);
  parameters.add<double>("--shadow-threshold",
                         "Lights darker than this part of the brightest are left out",
                         of_normal(&P::shadow_threshold), shading);
}

void add_surface_parameters(CLI::App& command, SensorChoice& choice) {
  ParameterAdder parameters(command, choice, "Surface");
  const auto add = [&](const char* name, const char* help,
                       double simulation::Reflectance::*member) {
    parameters.add<double>(
        name, help, of_surface(member),
        "--range-sensor structured-light, laser-line, rgbd or tof or --normal-sensor "
        "photometric-stereo");
  };
  using R = simulation::Reflectance;
  add("--dark-fraction", "Part of the surface in dark patches", &R::dark_fraction);
  add("--dark-albedo", "Albedo of the dark patches", &R::dark_albedo);
  add("--glossy-fraction", "Part of the surface in glossy patches", &R::glossy_fraction);
  add("--patch-size", "Shortest wave length of the patches [diameters]", &R::patch_size);
  add("--highlight-width", "Angle at which a highlight is 1/e [deg]", &R::highlight_width_deg);
  add("--highlight-strength", "Light of a highlight [that of white, frontal]",
      &R::highlight_strength);
}

}  // namespace

Result<void> SensorChoice::apply(simulation::SimulationOptions& options) const {
  options.range_sensor = kRangeSensors.at(range);
  options.normal_sensor = kNormalSensors.at(normal);
  if (looks_at_reflectance(options)) options.reflectance = simulation::patchy_surface();
  for (const auto& set : overrides)
    if (auto done = set(options); !done) return done;
  return {};
}

void add_simulation_options(CLI::App& command, simulation::SimulationOptions& options) {
  command.add_option("--views", options.views, "Number of views")
      ->check(positive_number())
      ->capture_default_str();
  command.add_option("--width", options.width, "Pixels of a row")->capture_default_str();
  command.add_option("--height", options.height, "Pixels of a column")->capture_default_str();
  command
      .add_option(
          "--rays", options.rays,
          "Rays of the sensor: pinhole, orthographic, line, or spherical (a turning scanner)")
      ->transform(CLI::CheckedTransformer(kRays))
      ->default_str("pinhole");
  command.add_option("--layout", options.layout, "Where the sensor stands: turntable or sphere")
      ->transform(CLI::CheckedTransformer(kLayouts))
      ->default_str("turntable");
  command
      .add_option("--distance", options.distance,
                  "From the sensor to the object's centre [diameters of the object]")
      ->capture_default_str();
  command
      .add_option("--fill", options.fill,
                  "Part of the smaller image side that the object fills, measured by its sphere")
      ->capture_default_str();
  command
      .add_option("--max-incidence", options.max_incidence_deg,
                  "Steepest angle between ray and normal that gives a sample [deg]")
      ->capture_default_str();
  command
      .add_option("--mesh-divisions", options.mesh_divisions,
                  "Fineness of the built-in object's true mesh; 0: none")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  command.add_option("--poses", options.pose, "Starting poses: exact, perturbed or absent")
      ->transform(CLI::CheckedTransformer(kPoses))
      ->default_str("perturbed");
  command
      .add_option("--pose-rotation", options.pose_rotation_deg,
                  "Error of perturbed poses [deg], about the object's centre")
      ->capture_default_str();
  command
      .add_option("--pose-translation", options.pose_translation,
                  "Error of perturbed poses [diameters of the object]")
      ->capture_default_str();
}

void add_sensor_options(CLI::App& command, SensorChoice& choice) {
  command
      .add_option("--range-sensor", choice.range,
                  "Range sensor: exact, white, structured-light, laser-line, rgbd or tof")
      ->check(CLI::IsMember(names_of(kRangeSensors)))
      ->capture_default_str()
      ->group("Range sensor");
  command
      .add_option("--normal-sensor", choice.normal,
                  "Normal sensor: exact, white, photometric-stereo or none")
      ->check(CLI::IsMember(names_of(kNormalSensors)))
      ->capture_default_str()
      ->group("Normal sensor");
  add_range_parameters(command, choice);
  add_normal_parameters(command, choice);
  add_surface_parameters(command, choice);
}

}  // namespace relief
