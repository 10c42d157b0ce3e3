#include <algorithm>
#include <memory>
#include <utility>

#include "relief/simulation/simulation_object.h"
#include "scan/mesh/triangle_tree.h"

namespace relief::simulation {

namespace {

// The tree refers to the mesh: both live as long as the caster does.
struct MeshWithTree {
  explicit MeshWithTree(TriangleMesh m) : mesh(std::move(m)), tree(mesh) {}
  TriangleMesh mesh;
  TriangleTree tree;
};

}  // namespace

Result<SimulationObject> mesh_object(TriangleMesh mesh, const std::string& unit) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite())
      return Error{ErrorKind::kBadInput,
                   "vertex " + std::to_string(i) + " of the mesh to scan is not finite"};
    box.extend(mesh.vertices[i]);
  }
  if (!(surface_area(mesh) > 0.0))
    return Error{ErrorKind::kBadInput, "the mesh to scan has no faces with area"};

  SimulationObject object;
  object.unit = unit;
  object.centre = box.center();
  for (const auto& vertex : mesh.vertices)
    object.radius = std::max(object.radius, (vertex - object.centre).norm());
  object.mesh = mesh;
  const auto target = std::make_shared<const MeshWithTree>(std::move(mesh));
  object.cast = [target](const Ray& ray) -> std::optional<SurfaceHit> {
    const auto hit = target->tree.first_hit(ray);
    if (!hit) return std::nullopt;
    return SurfaceHit{hit->range, face_cross(target->mesh, hit->face).stableNormalized()};
  };
  return object;
}

}  // namespace relief::simulation
