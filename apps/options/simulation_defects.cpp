#include "apps/options/simulation_defects.h"

#include <map>
#include <string>

namespace relief {

namespace {

const std::map<std::string, simulation::NormalMistake> kNormalMistakes = {
    {"none", simulation::NormalMistake::kNone},
    {"flip-x", simulation::NormalMistake::kFlipX},
    {"flip-y", simulation::NormalMistake::kFlipY},
    {"flip-z", simulation::NormalMistake::kFlipZ},
    {"swap-xy", simulation::NormalMistake::kSwapXY},
    {"world", simulation::NormalMistake::kWorldSpace}};

std::string name_of(simulation::NormalMistake mistake) {
  for (const auto& [name, value] : kNormalMistakes)
    if (value == mistake) return name;
  return "";
}

Json to_json(const simulation::BackgroundPlate& plate) {
  return {{"distance", plate.distance}, {"tilt_deg", plate.tilt_deg}};
}

Json to_json(const simulation::Glare& glare) {
  return {{"lamps", glare.lamps},
          {"lamp_angle_deg", glare.lamp_angle_deg},
          {"width_deg", glare.width_deg},
          {"range_error", glare.range_error}};
}

Json every_parameter(const simulation::ScanDefects& defects, bool undeclared_normals) {
  return {{"background", defects.background ? to_json(*defects.background) : Json()},
          {"noise_half", defects.noise_half},
          {"view_warp", defects.view_warp},
          {"glare", defects.glare ? to_json(*defects.glare) : Json()},
          {"outlier_fraction", defects.outlier_fraction},
          {"outlier_distance", defects.outlier_distance},
          {"quantisation", defects.quantisation},
          {"missing_fraction", defects.missing_fraction},
          {"normal_mistake", name_of(defects.normal_mistake)},
          {"undeclared_normals", undeclared_normals},
          {"focal_factor", defects.focal_factor},
          {"scale_factor", defects.scale_factor},
          {"radial_distortion", defects.radial_distortion},
          {"range_offset", defects.range_offset}};
}

}  // namespace

Result<simulation::ScanDefects> DefectChoice::chosen() const {
  simulation::ScanDefects chosen = defects;
  if (background) chosen.background = plate;
  if (glare) chosen.glare = highlights;
  const auto needs = [](const char* parameters, const char* flag) {
    return Error{ErrorKind::kBadInput,
                 std::string(parameters) + " have no meaning here; they need " + flag};
  };
  if (!background && plate != simulation::BackgroundPlate{})
    return needs("--background-distance and --background-tilt", "--background");
  if (!glare && highlights != simulation::Glare{})
    return needs("--glare-lamps, --glare-angle, --glare-width and --glare-error", "--glare");
  return chosen;
}

void add_defect_options(CLI::App& command, DefectChoice& choice) {
  const auto group = [](CLI::Option* option) { option->group("Defects"); };
  const auto add = [&](const char* name, double& value, const char* help) {
    group(command.add_option(name, value, help)->capture_default_str());
  };
  simulation::ScanDefects& defects = choice.defects;
  group(command.add_flag("--background", choice.background,
                         "A tilted plate behind the object that stands still before the sensor"));
  add("--background-distance", choice.plate.distance,
      "From the object's centre to the plate [diameters]");
  add("--background-tilt", choice.plate.tilt_deg,
      "Between the plate's normal and the sensor's axis [deg]");
  add("--noise-half", defects.noise_half, "Factor of the range noise in the right half of images");
  add("--view-warp", defects.view_warp,
      "Smooth error of the range, another in every view: RMS [sample spacings]");
  group(command.add_flag("--glare", choice.glare,
                         "Highlights of lamps that stand still before the sensor"));
  group(command.add_option("--glare-lamps", choice.highlights.lamps, "Number of the lamps")
            ->capture_default_str());
  add("--glare-angle", choice.highlights.lamp_angle_deg,
      "Between the lamps and the sensor's axis [deg]");
  add("--glare-width", choice.highlights.width_deg, "Angle at which a highlight is 1/e [deg]");
  add("--glare-error", choice.highlights.range_error,
      "Range error in its middle: standard deviation [sample spacings]");
  add("--outliers", defects.outlier_fraction, "Part of the samples that are thrown off");
  add("--outlier-distance", defects.outlier_distance,
      "By how much: standard deviation along the ray [sample spacings]");
  add("--quantisation", defects.quantisation, "Step of the range [sample spacings]; 0: none");
  add("--missing", defects.missing_fraction, "Part of the samples that are lost at random");
  group(command
            .add_option("--wrong-normals", defects.normal_mistake,
                        "Convention the normals are wrongly in: flip-x, flip-y, flip-z, swap-xy, "
                        "world or none")
            ->transform(CLI::CheckedTransformer(kNormalMistakes))
            ->default_str("none"));
  group(command.add_flag("--undeclared-normals", choice.undeclared_normals,
                         "The project does not say which axes and space its normals have"));
  add("--focal-factor", defects.focal_factor, "Factor of the focal length in the written cameras");
  add("--scale-factor", defects.scale_factor, "Factor of all ranges, poses staying as they are");
  add("--radial-distortion", defects.radial_distortion,
      "By which part rays at the image corner go farther out than the written cameras say");
  add("--range-offset", defects.range_offset, "What all ranges are too long by [sample spacings]");
}

Json defects_json(const simulation::ScanDefects& defects, bool undeclared_normals) {
  const Json all = every_parameter(defects, undeclared_normals);
  return all == every_parameter({}, false) ? Json() : all;
}

}  // namespace relief
