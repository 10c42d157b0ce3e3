#include "scan/mesh/mesh_components.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace relief {

namespace {

constexpr std::uint32_t kUnused = 0xffffffffu;

// The smallest vertex connected to each vertex.
std::vector<std::uint32_t> component_roots(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> root(mesh.vertices.size());
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const auto& face : mesh.faces) {
    for (const int k : {1, 2}) {
      const std::uint32_t a = find(face[0]), b = find(face[k]);
      root[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::uint32_t v = 0; v < root.size(); ++v) root[v] = find(v);
  return root;
}

template <typename T>
void compact(std::vector<T>& attribute, const std::vector<std::uint32_t>& new_index) {
  if (attribute.empty()) return;
  std::size_t kept = 0;
  for (std::size_t v = 0; v < new_index.size(); ++v)
    if (new_index[v] != kUnused) attribute[kept++] = attribute[v];
  attribute.resize(kept);
}

}  // namespace

void drop_unused_vertices(TriangleMesh& mesh) {
  std::vector<std::uint32_t> new_index(mesh.vertices.size(), kUnused);
  for (const auto& face : mesh.faces)
    for (const std::uint32_t v : face) new_index[v] = 0;
  std::uint32_t next = 0;
  for (auto& index : new_index)
    if (index != kUnused) index = next++;
  for (auto& face : mesh.faces)
    for (auto& v : face) v = new_index[v];
  compact(mesh.vertices, new_index);
  compact(mesh.normals, new_index);
  compact(mesh.quality, new_index);
  compact(mesh.views, new_index);
  compact(mesh.source_views, new_index);
  compact(mesh.filled, new_index);
  compact(mesh.colours, new_index);
}

RemovedComponents keep_largest_component(TriangleMesh& mesh) {
  const std::vector<std::uint32_t> root = component_roots(mesh);
  std::vector<double> area(mesh.vertices.size(), -1.0);
  std::size_t components = 0;
  double all = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    double& sum = area[root[mesh.faces[f][0]]];
    if (sum < 0.0) {
      sum = 0.0;
      ++components;
    }
    const double area_of_face = 0.5 * face_cross(mesh, f).norm();
    sum += area_of_face;
    all += area_of_face;
  }
  RemovedComponents removed;
  if (components > 0) {
    const auto largest =
        static_cast<std::uint32_t>(std::max_element(area.begin(), area.end()) - area.begin());
    removed.components = components - 1;
    removed.area_fraction = all > 0.0 ? 1.0 - area[largest] / all : 0.0;
    removed.faces =
        std::erase_if(mesh.faces, [&](const auto& face) { return root[face[0]] != largest; });
  }
  drop_unused_vertices(mesh);
  return removed;
}

}  // namespace relief
