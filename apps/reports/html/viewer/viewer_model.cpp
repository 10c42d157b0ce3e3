#include "apps/reports/html/viewer/viewer_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "apps/reports/html/viewer/cluster_vertices.h"
#include "apps/reports/html/viewer/model_statistics.h"
#include "relief/fusion/decimate_mesh.h"

namespace relief {

namespace {

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

void put_positions(const TriangleMesh& mesh, ViewerModel& model) {
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  model.low = box.min();
  model.high = box.max();
  const Eigen::Vector3d extent = box.sizes();
  model.positions.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    auto& position = model.positions.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      const double part = extent[axis] > 0.0 ? (vertex - model.low)[axis] / extent[axis] : 0.0;
      position[axis] = static_cast<std::uint16_t>(std::lround(65535.0 * part));
    }
  }
}

// A few extreme errors would leave all others one colour: the scale ends at the hundredths.
void put_errors(const TriangleMesh& mesh, ViewerModel& model) {
  std::vector<float> measured = measured_errors(mesh);
  if (measured.empty()) return;
  model.error_low = quantile(measured, 0.01);
  model.error_high = quantile(measured, 0.99);
  const double range = model.error_high - model.error_low;
  for (const float error : mesh.quality) {
    const double part = range > 0.0 ? (error - model.error_low) / range : 0.0;
    model.errors.push_back(std::isfinite(part) ? to_byte(255.0 * part) : 255);
  }
}

ViewerModel quantised(const TriangleMesh& mesh) {
  ViewerModel model;
  put_positions(mesh, model);
  model.faces.assign(mesh.faces.begin(), mesh.faces.end());
  put_errors(mesh, model);
  for (const std::uint16_t views : mesh.views) model.views.push_back(to_byte(views));
  model.sources.assign(mesh.source_views.begin(), mesh.source_views.end());
  model.filled.assign(mesh.filled.begin(), mesh.filled.end());
  for (const Colour& colour : mesh.colours) model.colours.push_back(colour);
  return model;
}

// Decimating a large mesh would take a tenth of the time of a whole run. What is many times too
// fine for the page is thinned by clustering first, which takes next to none.
constexpr double kDecimated = 1.5;  // Faces that are left to decimation, in those wanted.

TriangleMesh thinned(const TriangleMesh& mesh, std::size_t faces) {
  const double most = kDecimated * static_cast<double>(faces);
  // A plane in general position meets about 1.5 cubes per square of their side; a vertex has two
  // faces.
  double cell = std::sqrt(1.5 * surface_area(mesh) / (0.5 * most));
  TriangleMesh coarse = cluster_vertices(mesh, cell);
  while (static_cast<double>(coarse.faces.size()) > most) {
    cell *= 1.15;
    coarse = cluster_vertices(mesh, cell);
  }
  return coarse;
}

Result<fusion::DecimatedMesh> decimated_to(const TriangleMesh& mesh, std::size_t faces) {
  if (static_cast<double>(mesh.faces.size()) <= kDecimated * static_cast<double>(faces))
    return fusion::decimate_mesh(mesh, {.faces = faces});
  return fusion::decimate_mesh(thinned(mesh, faces), {.faces = faces});
}

}  // namespace

Result<ViewerModel> make_viewer_model(const TriangleMesh& mesh, std::size_t faces) {
  if (mesh.vertices.empty() || mesh.faces.empty())
    return Error{ErrorKind::kUnsolvable, "the model has no faces"};
  if (mesh.faces.size() <= faces) {
    ViewerModel model = quantised(mesh);
    model.faces_before = mesh.faces.size();
    return model;
  }
  const auto decimated = decimated_to(mesh, faces);
  if (!decimated) return decimated.error();
  if (decimated->mesh.faces.size() / 2 > faces)
    return Error{ErrorKind::kUnsolvable,
                 fmt::format("decimation left {} faces of {}, too many for a page: correct the "
                             "mesh first, or allow more with --viewer-faces",
                             decimated->mesh.faces.size(), mesh.faces.size())};
  ViewerModel model = quantised(decimated->mesh);
  model.faces_before = mesh.faces.size();
  return model;
}

Json to_json(const ViewerModel& model) {
  const auto vector = [](const Eigen::Vector3d& v) { return Json{v.x(), v.y(), v.z()}; };
  Json json = {{"vertices", model.positions.size()},
               {"faces", model.faces.size()},
               {"faces_before", model.faces_before},
               {"low", vector(model.low)},
               {"high", vector(model.high)}};
  if (!model.errors.empty()) json["error"] = {model.error_low, model.error_high};
  if (!model.views.empty())
    json["views_most"] = *std::max_element(model.views.begin(), model.views.end());
  json["filled"] = !model.filled.empty();
  json["colours"] = !model.colours.empty();
  return json;
}

}  // namespace relief
