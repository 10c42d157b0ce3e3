#include "apps/reports/html/viewer/view_camera.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace relief {

namespace {

bool is_pose(const Json& matrix) {
  if (!matrix.is_array() || matrix.size() != 4) return false;
  for (const Json& row : matrix) {
    if (!row.is_array() || row.size() != 4) return false;
    for (const Json& entry : row)
      if (!entry.is_number()) return false;
  }
  return true;
}

double number_in(const Json& object, const char* key, double fallback) {
  return object.contains(key) && object[key].is_number() ? object[key].get<double>() : fallback;
}

// Of pinholes the axis, of others what the project states.
std::optional<Eigen::Vector3d> direction_of(const Json& camera) {
  const Json model = camera.value("model", Json());
  if (model == "pinhole") return Eigen::Vector3d::UnitZ();
  if (model == "pinhole_gl") return -Eigen::Vector3d::UnitZ();
  const Json stated = camera.value("view_direction", Json());
  if (!stated.is_array() || stated.size() != 3) return std::nullopt;
  Eigen::Vector3d direction;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!stated[k].is_number()) return std::nullopt;
    direction[static_cast<Eigen::Index>(k)] = stated[k].get<double>();
  }
  if (!(direction.norm() > 0.0)) return std::nullopt;
  return direction.normalized();
}

void put_opening(const Json& camera, ViewCamera& drawn) {
  const double fx = number_in(camera, "fx", 0.0), fy = number_in(camera, "fy", 0.0);
  const double width = number_in(camera, "width", 0.0), height = number_in(camera, "height", 0.0);
  if (fx == 0.0 || fy == 0.0 || width <= 0.0 || height <= 0.0) return;
  const double cx = number_in(camera, "cx", 0.5 * (width - 1.0));
  const double cy = number_in(camera, "cy", 0.5 * (height - 1.0));
  drawn.left = -cx / fx;
  drawn.right = (width - 1.0 - cx) / fx;
  drawn.top = -cy / fy;
  drawn.bottom = (height - 1.0 - cy) / fy;
}

void put_camera(const Json& camera, ViewCamera& drawn) {
  drawn.direction = direction_of(camera);
  if (drawn.direction && drawn.direction->z() < 0.0) drawn.forward = -1.0;
  put_opening(camera, drawn);
}

Eigen::Matrix3d rotation_of(const ViewCamera& camera) {
  Eigen::Matrix3d rotation;
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 3; ++column)
      rotation(row, column) =
          camera.world_from_view[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)]
              .get<double>();
  return rotation;
}

// In the usual frames a camera that looks along +z has y down, one that looks along -z has y up.
Eigen::Vector3d upright_axis(const std::vector<ViewCamera>& cameras) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ViewCamera& camera : cameras)
    if (camera.direction) sum -= camera.direction->z() * rotation_of(camera).col(1);
  constexpr double kSure = 1e-6;  // Of unit vectors: less is rounding.
  Eigen::Index axis = 0;
  if (!(sum.cwiseAbs().maxCoeff(&axis) > kSure)) return Eigen::Vector3d::UnitZ();
  return (sum[axis] < 0.0 ? -1.0 : 1.0) * Eigen::Vector3d::Unit(axis);
}

bool is_measured(const TriangleMesh& mesh, const TriangleMesh::Face& face) {
  return mesh.filled.empty() || std::none_of(face.begin(), face.end(), [&](auto vertex) {
           return mesh.filled[static_cast<std::size_t>(vertex)] != 0;
         });
}

// Normals of some of the faces that were measured, as long as twice their areas.
std::vector<Eigen::Vector3d> measured_normals(const TriangleMesh& mesh) {
  constexpr std::size_t kFaces = 20000;  // Directions hardly change with more.
  const std::size_t step = std::max<std::size_t>(1, mesh.faces.size() / kFaces);
  std::vector<Eigen::Vector3d> normals;
  for (std::size_t f = 0; f < mesh.faces.size(); f += step)
    if (is_measured(mesh, mesh.faces[f])) normals.push_back(face_cross(mesh, f));
  return normals;
}

double area_towards(const std::vector<Eigen::Vector3d>& normals, const Eigen::Vector3d& direction) {
  double sum = 0.0;
  for (const Eigen::Vector3d& normal : normals) sum += std::max(0.0, normal.dot(direction));
  return sum;
}

}  // namespace

std::optional<ViewCamera> view_camera(const Json& view) {
  if (!view.is_object() || !view.contains("world_from_view") || !is_pose(view["world_from_view"]))
    return std::nullopt;
  ViewCamera drawn;
  if (view.contains("name") && view["name"].is_string()) drawn.name = view["name"];
  drawn.world_from_view = view["world_from_view"];
  if (view.contains("camera") && view["camera"].is_object()) put_camera(view["camera"], drawn);
  return drawn;
}

Json to_json(const ViewCamera& camera) {
  return {{"name", camera.name},      {"world_from_view", camera.world_from_view},
          {"left", camera.left},      {"right", camera.right},
          {"top", camera.top},        {"bottom", camera.bottom},
          {"forward", camera.forward}};
}

InitialViewpoint initial_viewpoint(const TriangleMesh& mesh,
                                   const std::vector<ViewCamera>& cameras) {
  InitialViewpoint viewpoint;
  viewpoint.up = upright_axis(cameras);
  const std::vector<Eigen::Vector3d> normals = measured_normals(mesh);
  double most = 0.0;
  for (const ViewCamera& camera : cameras) {
    if (!camera.direction) continue;
    const Eigen::Vector3d towards = -(rotation_of(camera) * *camera.direction).normalized();
    const double area = area_towards(normals, towards);
    if (!(area > most)) continue;
    most = area;
    viewpoint.towards_viewer = towards;
  }
  return viewpoint;
}

}  // namespace relief
