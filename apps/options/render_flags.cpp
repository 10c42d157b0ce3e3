#include "apps/options/render_flags.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <sstream>

#include "apps/options/number_checks.h"

namespace relief {

namespace {

using rendering::Background;
using rendering::RenderStyle;
using rendering::ShadingNormals;

const std::map<std::string, RenderStyle> kStyles = {{"shaded", RenderStyle::kShaded},
                                                    {"grazing", RenderStyle::kGrazing},
                                                    {"accessibility", RenderStyle::kAccessibility},
                                                    {"depth", RenderStyle::kDepth},
                                                    {"normals", RenderStyle::kNormals},
                                                    {"expected_error", RenderStyle::kExpectedError},
                                                    {"filled", RenderStyle::kFilled},
                                                    {"views", RenderStyle::kViews},
                                                    {"distance", RenderStyle::kDistance},
                                                    {"colours", RenderStyle::kColours}};
const std::map<std::string, Background> kBackgrounds = {{"white", Background::kWhite},
                                                        {"transparent", Background::kTransparent}};
const std::map<std::string, ShadingNormals> kNormals = {{"own", ShadingNormals::kOwn},
                                                        {"geometry", ShadingNormals::kGeometry},
                                                        {"faces", ShadingNormals::kFaces}};
const std::map<std::string, Eigen::Vector3d> kAxes = {{"x", {1, 0, 0}},   {"y", {0, 1, 0}},
                                                      {"z", {0, 0, 1}},   {"-x", {-1, 0, 0}},
                                                      {"-y", {0, -1, 0}}, {"-z", {0, 0, -1}}};

constexpr int kLargestSide = 16384;  // [pixels]

// Of a pixel. A mean over n rays errs by 0.5 / sqrt(n) at the most: by half of one of 255 greys.
constexpr int kMostAmbientRays = 256 * 256;

// `least` to `most` numbers with commas between them.
std::vector<double> numbers(const std::string& option, const std::string& text, std::size_t least,
                            std::size_t most) {
  std::vector<double> values;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) {
    double value = 0.0;
    if (!CLI::detail::lexical_cast(part, value))
      throw CLI::ValidationError(option, "'" + part + "' in " + text + " is not a number");
    values.push_back(value);
  }
  if (values.size() < least || values.size() > most)
    throw CLI::ValidationError(option, text + " has " + std::to_string(values.size()) +
                                           " numbers; give " + std::to_string(least) +
                                           (most > least ? " or " + std::to_string(most) : "") +
                                           " with commas between them");
  return values;
}

rendering::ViewingDirection direction_of(const std::string& text) {
  const auto values = numbers("--view", text, 2, 3);
  if (values[1] < -90.0 || values[1] > 90.0)
    throw CLI::ValidationError("--view", text + ": elevations are from -90 to 90");
  return {values[0], values[1], values.size() > 2 ? values[2] : 0.0};
}

void read_size(const std::string& text, RenderFlags& flags) {
  char rest = 0;
  rendering::FramingOptions& framing = flags.framing;
  const int found = std::sscanf(text.c_str(), "%dx%d%c", &framing.width, &framing.height, &rest);
  const auto [least, most] = std::minmax(framing.width, framing.height);
  if (found != 2 || least < 1 || most > kLargestSide)
    throw CLI::ValidationError(
        "--size",
        text + ": give WIDTHxHEIGHT in pixels, as 1024x768, up to " + std::to_string(kLargestSide));
  flags.has_size = true;
}

std::array<double, 2> range_of(const std::string& text) {
  const auto values = numbers("--range", text, 2, 2);
  if (!(values[0] < values[1]))
    throw CLI::ValidationError("--range", text + ": the first value must be the smaller one");
  return {values[0], values[1]};
}

rendering::LightDirection light_of(const std::string& text) {
  const auto values = numbers("--light", text, 2, 2);
  return {values[0], values[1]};
}

void add_camera_flags(CLI::App& command, RenderFlags& flags) {
  auto* group = command.add_option_group("Camera");
  rendering::FramingOptions& framing = flags.framing;
  group
      ->add_option_function<std::vector<std::string>>(
          "--view",
          [&flags](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) flags.directions.push_back(direction_of(text));
          },
          "AZIMUTH,ELEVATION[,ROLL] of the viewer of a model [deg]; 0,0 is at -y where z is up. "
          "Several times: in one picture; default: 30,20")
      ->allow_extra_args(false)
      ->type_name("ANGLES");
  group
      ->add_option_function<std::string>(
          "--up", [&framing](const std::string& axis) { framing.up = kAxes.at(axis); },
          "The vertical of a model: x, y, z, -x, -y or -z")
      ->check(CLI::IsMember(kAxes))
      ->default_str("z");
  group
      ->add_option("--field-of-view", framing.field_of_view_deg,
                   "Angle of the longer side [deg]; 0: orthographic")
      ->check(CLI::Range(0.0, 120.0))
      ->capture_default_str();
  group
      ->add_option_function<std::string>(
          "--size", [&flags](const std::string& text) { read_size(text, flags); },
          "WIDTHxHEIGHT [pixels], of each single picture in a sheet; default: 1024x768, in sheets "
          "512x384")
      ->type_name("SIZE");
  auto* turntable = group
                        ->add_option("--turntable", flags.turntable,
                                     "So many pictures all round a model: OUT-000.png ...")
                        ->check(CLI::Range(1, 1000));
  group->add_flag("--contact-sheet", flags.contact_sheet, "A model from six sides in one picture")
      ->excludes(turntable);
  group->add_option("--only", flags.only, "Of a project: the views of these names")
      ->delimiter(',')
      ->allow_extra_args(false);
}

void add_surface_flags(CLI::App& command, RenderFlags& flags) {
  auto* group = command.add_option_group("Surface");
  rendering::RenderOptions& options = flags.options;
  group
      ->add_option("--style", flags.styles,
                   "shaded, grazing, accessibility, depth, normals, expected_error, filled, views, "
                   "distance or colours; several with commas: side by side")
      ->transform(CLI::CheckedTransformer(kStyles).description(""))
      ->delimiter(',')
      ->allow_extra_args(false)
      ->default_str("shaded");
  group
      ->add_option_function<std::string>(
          "--light", [&options](const std::string& text) { options.light = light_of(text); },
          "AZIMUTH,ELEVATION of the light [deg] of shaded and grazing; 0,0 is the viewer, positive "
          "is right and above")
      ->type_name("ANGLES");
  group
      ->add_option_function<std::string>(
          "--range", [&options](const std::string& text) { options.range = range_of(text); },
          "LOW,HIGH values at the ends of the colour bar; default: from the data")
      ->type_name("VALUES");
  group->add_option("--truth", flags.truth, "The mesh to which the style distance measures");
  group
      ->add_option_function<std::string>(
          "--normals", [&flags](const std::string& name) { flags.normals = kNormals.at(name); },
          "For light: own, geometry or faces; default: own for models and the style normals, "
          "geometry for views")
      ->check(CLI::IsMember(kNormals));
}

void add_quality_flags(CLI::App& command, RenderFlags& flags) {
  auto* group = command.add_option_group("Picture");
  rendering::RenderOptions& options = flags.options;
  group->add_option("--antialiasing", options.antialiasing, "n: every pixel has n x n rays")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  group
      ->add_option("--ambient-rays", options.ambient_rays,
                   "Rays of a pixel that look at the sky, of accessibility")
      ->check(CLI::Range(1, kMostAmbientRays))
      ->capture_default_str();
  group
      ->add_option("--ambient-reach", options.ambient_reach,
                   "How far they look, as a part of the model's diagonal")
      ->check(positive_number())
      ->capture_default_str();
  group->add_option("--background", options.background, "white or transparent")
      ->transform(CLI::CheckedTransformer(kBackgrounds).description(""))
      ->default_str("white");
  group->add_flag("--no-legend", flags.no_legend, "No colour bars and captions in the picture");
}

}  // namespace

bool RenderFlags::shows(RenderStyle style) const {
  return std::find(styles.begin(), styles.end(), style) != styles.end();
}

void add_render_flags(CLI::App& command, RenderFlags& flags) {
  add_camera_flags(command, flags);
  add_surface_flags(command, flags);
  add_quality_flags(command, flags);
}

}  // namespace relief
