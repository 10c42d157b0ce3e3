#pragma once

#include <cstddef>
#include <cstdint>

#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/paged_array.h"

namespace relief::hybrid {

/// The edges of a mesh from each of their ends. Those of vertex i are at begin[i] to begin[i + 1],
/// by rising neighbour; every edge is there twice with the same values.
struct MeshGraph {
  PagedArray<std::size_t> begin;
  PagedArray<std::uint32_t> neighbour;
  PagedArray<float> edge_area;    ///< A third of the area of the faces at the edge [unit^2].
  PagedArray<float> vertex_area;  ///< A third of the area of the faces at the vertex [unit^2].

  std::size_t vertices() const { return vertex_area.size(); }
};

/// Indices of faces must be in range. Memory and time linear in the size of the mesh.
MeshGraph mesh_graph(const TriangleMesh& mesh);

}  // namespace relief::hybrid
