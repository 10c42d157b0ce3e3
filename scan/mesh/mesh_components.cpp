#include "scan/mesh/mesh_components.h"

#include <algorithm>
#include <cstdint>

#include "scan/base/disjoint_sets.h"
#include "scan/base/memory/paged_array.h"
#include "scan/base/parallel.h"
#include "scan/mesh/vertex_arrays.h"

namespace relief {

namespace {

template <typename T>
void compact(PagedVector<T>& attribute, const PagedArray<std::uint8_t>& used) {
  if (attribute.empty()) return;
  std::size_t kept = 0;
  serial_for(used.size(), [&](std::size_t v) {
    if (used[v]) attribute[kept++] = attribute[v];
  });
  attribute.resize(kept);
}

}  // namespace

void drop_unused_vertices(TriangleMesh& mesh) {
  PagedArray<std::uint8_t> used(mesh.vertices.size());
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    for (const std::uint32_t v : mesh.faces[f]) used[v] = 1;
  });
  PagedArray<std::uint32_t> new_index(used.size());
  std::uint32_t count = 0;
  serial_for(used.size(), [&](std::size_t v) { new_index[v] = used[v] ? count++ : count; });
  if (count == used.size()) return;
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    for (auto& v : mesh.faces[f]) v = new_index[v];
  });
  visit_vertex_arrays(mesh, [&](auto& array) { compact(array, used); });
}

MeshComponents find_components(const TriangleMesh& mesh) {
  DisjointSets sets(mesh.vertices.size());
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    for (const std::size_t k : {1u, 2u}) sets.join(mesh.faces[f][0], mesh.faces[f][k]);
  });
  MeshComponents components;
  components.of_vertex = PagedArray<std::uint32_t>(mesh.vertices.size());
  std::uint32_t count = 0;
  serial_for(mesh.vertices.size(), [&](std::size_t v) {
    const std::uint32_t first = sets.find(static_cast<std::uint32_t>(v));
    components.of_vertex[v] = first == v ? count++ : components.of_vertex[first];
  });
  components.area.assign(count, 0.0);
  components.faces.assign(count, 0);
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    const std::uint32_t component = components.of_vertex[mesh.faces[f][0]];
    components.area[component] += 0.5 * face_cross(mesh, f).norm();
    ++components.faces[component];
  });
  return components;
}

RemovedComponents keep_components(const MeshComponents& components, const std::vector<bool>& kept,
                                  TriangleMesh& mesh) {
  RemovedComponents removed;
  double all = 0.0, area = 0.0;
  for (std::size_t c = 0; c < components.count(); ++c) {
    all += components.area[c];
    if (kept[c] || components.faces[c] == 0) continue;
    area += components.area[c];
    ++removed.components;
    removed.faces += components.faces[c];
  }
  removed.area_fraction = all > 0.0 ? area / all : 0.0;
  if (removed.components > 0) {
    std::size_t count = 0;
    serial_for(mesh.faces.size(), [&](std::size_t f) {
      if (kept[components.of_vertex[mesh.faces[f][0]]]) mesh.faces[count++] = mesh.faces[f];
    });
    mesh.faces.resize(count);
  }
  drop_unused_vertices(mesh);
  return removed;
}

RemovedComponents keep_largest_component(TriangleMesh& mesh) {
  const MeshComponents components = find_components(mesh);
  std::vector<bool> kept(components.count(), false);
  const auto largest = std::max_element(components.area.begin(), components.area.end());
  if (!kept.empty()) kept[static_cast<std::size_t>(largest - components.area.begin())] = true;
  return keep_components(components, kept, mesh);
}

}  // namespace relief
