#include "fusion/holes/filled_regions.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "scan/base/disjoint_sets.h"
#include "scan/mesh/mesh_components.h"

namespace relief::fusion {

namespace {

bool has_filled(const TriangleMesh& mesh, const TriangleMesh::Face& face) {
  return std::any_of(face.begin(), face.end(), [&](std::uint32_t v) { return mesh.filled[v]; });
}

}  // namespace

std::vector<std::uint32_t> regions_of(const TriangleMesh& mesh,
                                      const std::vector<std::uint8_t>& set) {
  DisjointSets regions(mesh.vertices.size());
  for (const auto& face : mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = face[k], b = face[(k + 1) % 3];
      if (set[a] && set[b]) regions.join(a, b);
    }
  }
  std::vector<std::uint32_t> first(mesh.vertices.size());
  for (std::uint32_t v = 0; v < first.size(); ++v) first[v] = regions.find(v);
  return first;
}

double filled_area_fraction(const TriangleMesh& mesh) {
  double filled = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    if (has_filled(mesh, mesh.faces[f])) filled += 0.5 * face_cross(mesh, f).norm();
  return filled / surface_area(mesh);
}

void open_holes(TriangleMesh& mesh, double largest) {
  const std::vector<std::uint32_t> region = regions_of(mesh, mesh.filled);
  std::vector<std::uint8_t> open(mesh.vertices.size(), 0);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (mesh.filled[v] && static_cast<double>(mesh.quality[v]) > largest) open[region[v]] = 1;
  std::erase_if(mesh.faces, [&](const auto& face) {
    return std::any_of(face.begin(), face.end(), [&](std::uint32_t v) { return open[region[v]]; });
  });
  drop_unused_vertices(mesh);
}

}  // namespace relief::fusion
