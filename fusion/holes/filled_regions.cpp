#include "fusion/holes/filled_regions.h"

#include <algorithm>
#include <cstdint>

#include "scan/base/disjoint_sets.h"
#include "scan/base/parallel.h"
#include "scan/mesh/mesh_components.h"

namespace relief::fusion {

namespace {

bool has_filled(const TriangleMesh& mesh, const TriangleMesh::Face& face) {
  return std::any_of(face.begin(), face.end(), [&](std::uint32_t v) { return mesh.filled[v]; });
}

}  // namespace

PagedArray<std::uint32_t> regions_of(const TriangleMesh& mesh, std::span<const std::uint8_t> set) {
  DisjointSets regions(mesh.vertices.size());
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
      if (set[a] && set[b]) regions.join(a, b);
    }
  });
  PagedArray<std::uint32_t> first(mesh.vertices.size());
  serial_for(first.size(),
             [&](std::size_t v) { first[v] = regions.find(static_cast<std::uint32_t>(v)); });
  return first;
}

double filled_area_fraction(const TriangleMesh& mesh) {
  double filled = 0.0;
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    if (has_filled(mesh, mesh.faces[f])) filled += 0.5 * face_cross(mesh, f).norm();
  });
  return filled / surface_area(mesh);
}

void open_holes(TriangleMesh& mesh, double largest) {
  const auto region = regions_of(mesh, mesh.filled);
  PagedArray<std::uint8_t> open(mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (mesh.filled[v] && static_cast<double>(mesh.quality[v]) > largest) open[region[v]] = 1;
  std::erase_if(mesh.faces, [&](const auto& face) {
    return std::any_of(face.begin(), face.end(), [&](std::uint32_t v) { return open[region[v]]; });
  });
  drop_unused_vertices(mesh);
}

}  // namespace relief::fusion
