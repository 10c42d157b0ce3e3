#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/floats/raw_floats.h"
#include "scan/io/images/image_limits.h"
#include "scan/io/project/json/json_object_private.h"
#include "scan/io/project/view_spec.h"

namespace relief {

namespace {

using nlohmann::json;

std::filesystem::path resolve(const std::string& file, const std::filesystem::path& project,
                              const std::string& place) {
  if (file.empty()) throw JsonError(place + ": the file name is empty");
  return project.parent_path() / file;  // an absolute name stays as it is
}

ImageSize read_size(JsonObject& image) {
  const Eigen::VectorXd sides = image.numbers("size", 2);
  for (const double side : sides)
    if (side < 1.0 || side > kMaxImageSide || side != std::floor(side))
      throw JsonError(image.place("size") +
                      ": expected [width, height], two whole numbers from 1 to " +
                      std::to_string(kMaxImageSide));
  return {static_cast<int>(sides[0]), static_cast<int>(sides[1])};
}

// The file and the size of an image. Those without a header of their own need the size.
ImageFile take_image(JsonObject& image, const std::filesystem::path& project) {
  ImageFile taken{resolve(image.text("file"), project, image.place("file"))};
  if (image.has("size")) taken.size = read_size(image);
  if (!taken.size && has_raw_ending(taken.file))
    throw JsonError(image.place("size") +
                    ": missing; a file of bare floats needs \"size\": [WIDTH, HEIGHT] beside "
                    "\"file\"");
  return taken;
}

ImageFile read_image_file(JsonObject object, const std::filesystem::path& project) {
  ImageFile image = take_image(object, project);
  object.finish();
  return image;
}

void read_grid(JsonObject grid, const std::filesystem::path& project, ViewSpec& spec) {
  spec.grid = resolve(grid.text("file"), project, grid.place("file"));
  if (grid.has("scan")) spec.grid_options.scan = grid.index("scan");
  if (grid.has("viewpoint"))
    spec.grid_options.viewpoint = Eigen::Vector3d(grid.numbers("viewpoint", 3));
  if (grid.has("pose"))
    spec.grid_options.ignore_pose = grid.choice<bool>("pose", {{"take", false}, {"ignore", true}});
  grid.finish();
}

Eigen::Vector3d read_direction(JsonObject& camera, const std::string& key) {
  const Eigen::Vector3d direction = camera.numbers(key, 3);
  if (!(direction.norm() > 0.0)) throw JsonError(camera.place(key) + ": has no length");
  return direction.normalized();
}

// Drafts have focal lengths of 0 where none are known: these take `of_drafts`, as a whole.
void read_pinhole(JsonObject& camera, const std::optional<PinholeIntrinsics>& of_drafts,
                  CameraSpec& spec) {
  spec.intrinsics = {camera.number("fx"), camera.number("fy"), camera.number("cx"),
                     camera.number("cy")};
  const auto is_draft = [&] { return spec.intrinsics.fx == 0.0 || spec.intrinsics.fy == 0.0; };
  if (of_drafts && is_draft()) spec.intrinsics = *of_drafts;
  if (is_draft())
    throw JsonError(camera.place(spec.intrinsics.fx == 0.0 ? "fx" : "fy") +
                    ": is 0, but must be a number other than 0: the focal length in pixels; write "
                    "it here, or give --intrinsics FX FY CX CY");
}

void read_orthographic(JsonObject& camera, CameraSpec& spec) {
  if (camera.has("view_direction")) spec.view_direction = read_direction(camera, "view_direction");
  if (!camera.has("origin") && !camera.has("step_u") && !camera.has("step_v")) return;
  spec.origin = Eigen::Vector3d(camera.numbers("origin", 3));
  spec.step_u = Eigen::Vector3d(camera.numbers("step_u", 3));
  spec.step_v = Eigen::Vector3d(camera.numbers("step_v", 3));
  if (!spec.view_direction) throw JsonError(camera.place("view_direction") + ": missing");
  Eigen::Matrix3d axes;
  axes << *spec.step_u, *spec.step_v, *spec.view_direction;
  if (!(std::abs(axes.determinant()) > 1e-9 * spec.step_u->norm() * spec.step_v->norm()))
    throw JsonError(camera.place("step_u") +
                    ": step_u, step_v and view_direction must span the space");
}

void read_rational(JsonObject& camera, CameraSpec& spec) {
  spec.projection.u_numerator = camera.numbers("u_numerator", 4);
  spec.projection.u_denominator = camera.numbers("u_denominator", 4);
  spec.projection.v_numerator = camera.numbers("v_numerator", 4);
  spec.projection.v_denominator = camera.numbers("v_denominator", 4);
  spec.view_direction = read_direction(camera, "view_direction");
}

// Either `azimuth`: a number for each column, or `azimuth` of column 0 and `azimuth_step`; the same
// for elevations and rows. In degrees.
std::vector<double> read_angles(JsonObject& camera, const std::string& key,
                                std::optional<int> count, const char* size_key) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  constexpr int kLargestSide = 1 << 20;  // pixels; far more than scanners have
  if (!count || *count > kLargestSide)
    throw JsonError(camera.place(size_key) + ": missing or too large for a spherical camera");
  std::vector<double> angles;
  if (camera.is_list(key)) {
    const Eigen::VectorXd listed = camera.numbers(key, *count);
    for (const double angle : listed) angles.push_back(angle * kDegree);
    return angles;
  }
  const double first = camera.number(key), step = camera.nonzero(key + "_step");
  if (!(std::abs(step) * (*count - 1) <= 360.0 * (1.0 + 1e-6)))
    throw JsonError(camera.place(key + "_step") + ": times the steps is more than a turn");
  for (int i = 0; i < *count; ++i) angles.push_back((first + i * step) * kDegree);
  return angles;
}

void read_spherical(JsonObject& camera, CameraSpec& spec) {
  spec.angles.azimuth = read_angles(camera, "azimuth", spec.width, "width");
  spec.angles.elevation = read_angles(camera, "elevation", spec.height, "height");
  if (!spec.angles.valid())
    throw JsonError(camera.place("azimuth") +
                    ": azimuths and elevations [deg] must each grow or fall strictly, over at most "
                    "a turn and from -90 to 90; a camera needs two columns and rows");
}

CameraSpec read_camera(JsonObject camera, const std::optional<PinholeIntrinsics>& of_drafts) {
  using Model = CameraSpec::Model;
  CameraSpec spec;
  spec.model = camera.choice<Model>("model", {{"pinhole", Model::kPinhole},
                                              {"pinhole_gl", Model::kPinholeGl},
                                              {"orthographic", Model::kOrthographic},
                                              {"rational", Model::kRational},
                                              {"spherical", Model::kSpherical}});
  if (camera.has("width")) spec.width = camera.positive_integer("width");
  if (camera.has("height")) spec.height = camera.positive_integer("height");
  if (spec.model == Model::kOrthographic)
    read_orthographic(camera, spec);
  else if (spec.model == Model::kRational)
    read_rational(camera, spec);
  else if (spec.model == Model::kSpherical)
    read_spherical(camera, spec);
  else
    read_pinhole(camera, of_drafts, spec);
  camera.finish();
  return spec;
}

// A description that begins with the file and the size of its image.
template <typename Spec>
Spec spec_of_image(JsonObject& image, const std::filesystem::path& project) {
  Spec spec;
  ImageFile taken = take_image(image, project);
  spec.file = std::move(taken.file);
  spec.size = taken.size;
  return spec;
}

DepthSpec read_depth(JsonObject depth, const std::filesystem::path& project) {
  auto spec = spec_of_image<DepthSpec>(depth, project);
  if (depth.has("scale")) spec.scale = depth.positive("scale");
  if (depth.has("kind")) spec.along_ray = depth.choice<bool>("kind", {{"z", false}, {"ray", true}});
  depth.finish();
  return spec;
}

DeviationSpec read_deviation(JsonObject deviation, const std::filesystem::path& project) {
  auto spec = spec_of_image<DeviationSpec>(deviation, project);
  if (deviation.has("scale")) spec.scale = deviation.positive("scale");
  deviation.finish();
  return spec;
}

NormalSpec read_normals(JsonObject normals, const std::filesystem::path& project) {
  auto spec = spec_of_image<NormalSpec>(normals, project);
  if (normals.has("encoding"))
    spec.encoding = normals.choice<NormalEncoding>(
        "encoding", {{"rgb", NormalEncoding::kRgb}, {"unit", NormalEncoding::kUnit}});
  if (normals.has("axes"))
    spec.axes = normals.choice<NormalAxes>(
        "axes", {{"opencv", NormalAxes::kOpencv}, {"opengl", NormalAxes::kOpengl}});
  if (normals.has("space"))
    spec.space = normals.choice<NormalSpace>(
        "space", {{"camera", NormalSpace::kCamera}, {"world", NormalSpace::kWorld}});
  normals.finish();
  return spec;
}

void read_pose(JsonObject& view, ViewSpec& spec) {
  if (view.has("world_from_view")) {
    const auto motion =
        rigid_motion_from_matrix(view.matrix4("world_from_view"),
                                 view.place("world_from_view") + " (view " + spec.name + ")");
    if (!motion) throw JsonError(motion.error().message);
    spec.world_from_view = *motion;
    spec.pose = PoseKind::kGuess;
  }
  if (!view.has("pose_is")) return;
  const auto kind =
      view.choice<PoseKind>("pose_is", {{"known", PoseKind::kKnown}, {"guess", PoseKind::kGuess}});
  if (spec.pose == PoseKind::kAbsent)
    throw JsonError(view.place("pose_is") + ": says what world_from_view is, which is missing");
  spec.pose = kind;
}

ViewSpec read_view(JsonObject view, const std::filesystem::path& project,
                   const std::optional<PinholeIntrinsics>& of_drafts) {
  ViewSpec spec;
  spec.name = view.text("name");
  if (spec.name.empty()) throw JsonError(view.place("name") + ": is empty");
  if (view.has("depth")) spec.depth = read_depth(view.object("depth"), project);
  if (view.has("grid")) read_grid(view.object("grid"), project, spec);
  if (spec.depth.has_value() == spec.grid.has_value())
    throw JsonError(view.place("depth") + ": view " + spec.name +
                    " needs either depth or grid, and only one of them");
  if (view.has("camera")) spec.camera = read_camera(view.object("camera"), of_drafts);
  if (spec.depth && !spec.camera)
    throw JsonError(view.place("camera") + ": missing; depth without a camera gives no points");
  if (spec.depth && spec.camera->model == CameraSpec::Model::kOrthographic && !spec.camera->origin)
    throw JsonError(view.place("camera.origin") +
                    ": missing; an orthographic depth map needs "
                    "origin, step_u, step_v and view_direction");
  if (view.has("normals")) spec.normals = read_normals(view.object("normals"), project);
  if (view.has("mask")) spec.mask = read_image_file(view.object("mask"), project);
  if (view.has("confidence")) spec.confidence = read_image_file(view.object("confidence"), project);
  if (view.has("color")) spec.colour = read_image_file(view.object("color"), project);
  if (view.has("deviation")) spec.deviation = read_deviation(view.object("deviation"), project);
  if (view.has("samples"))
    spec.samples = view.choice<SampleOrigin>(
        "samples", {{"raw", SampleOrigin::kRaw}, {"refined", SampleOrigin::kRefined}});
  read_pose(view, spec);
  view.finish();
  return spec;
}

// Numbers that are none come from the program that wrote the file, where views go by their names.
ViewSpec read_named_view(JsonObject view, const std::filesystem::path& project,
                         const std::optional<PinholeIntrinsics>& of_drafts) {
  try {
    return read_view(view, project, of_drafts);
  } catch (const NonFiniteNumber& error) {
    throw JsonError("view " + view.text("name") + ": " + error.what());
  }
}

ProjectSpec read_document(const json& document, const std::filesystem::path& path,
                          const std::optional<PinholeIntrinsics>& of_drafts) {
  JsonObject root(document, "");
  if (!root.has("format"))
    throw JsonError("format: missing; a project begins with \"format\": \"relief-scan\"");
  if (root.text("format") != "relief-scan")
    throw JsonError("format: is '" + root.text("format") + "', expected 'relief-scan'");
  if (root.number("version") != 1.0)
    throw JsonError("version: " + root.at("version").dump() + " is unknown; this program reads 1");
  ProjectSpec project;
  project.unit = root.has("unit") ? root.text("unit") : "mm";
  const json& views = root.at("views");
  if (!views.is_array() || views.empty())
    throw JsonError("views: expected a list of at least one view");
  std::set<std::string> names;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::string place = "views[" + std::to_string(i) + "]";
    project.views.push_back(read_named_view(JsonObject(views[i], place), path, of_drafts));
    if (!names.insert(project.views.back().name).second)
      throw JsonError(place + ".name: a second view is named '" + project.views.back().name + "'");
  }
  root.finish();
  return project;
}

// What is wrong with a text that is no JSON because of numbers of Python.
std::optional<Error> error_of_python_numbers(const std::string& text,
                                             const std::filesystem::path& path) {
  const json document = json::parse(quote_python_numbers(text), nullptr, false, true);
  try {
    if (!document.is_discarded()) read_document(document, path, std::nullopt);
  } catch (const JsonError& error) {
    return bad_input(path, error.what());
  }
  return std::nullopt;
}

std::string line_and_column(const std::string& text, std::size_t byte) {
  const auto end =
      text.begin() + static_cast<std::ptrdiff_t>(std::min(text.size(), byte > 0 ? byte - 1 : 0));
  const auto line = std::count(text.begin(), end, '\n') + 1;
  const auto line_start = std::find(std::make_reverse_iterator(end), text.rend(), '\n').base();
  return std::to_string(line) + ":" + std::to_string(end - line_start + 1);
}

}  // namespace

Result<ProjectSpec> parse_scan_json(const std::string& text, const std::filesystem::path& path,
                                    const std::optional<PinholeIntrinsics>& of_drafts) {
  try {
    return read_document(json::parse(text, nullptr, true, /*ignore_comments=*/true), path,
                         of_drafts);
  } catch (const json::parse_error& error) {
    if (auto python = error_of_python_numbers(text, path)) return *python;
    return Error{ErrorKind::kBadInput,
                 path.string() + ":" + line_and_column(text, error.byte) + ": not valid JSON here"};
  } catch (const JsonError& error) {
    return bad_input(path, error.what());
  } catch (const json::exception& error) {
    return bad_input(path, error.what());
  }
}

}  // namespace relief
