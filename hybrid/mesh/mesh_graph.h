#pragma once

#include <cstddef>
#include <cstdint>

#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/paged_array.h"

namespace relief::hybrid {

/// The neighbours of each vertex. Those of vertex i are at begin[i] to begin[i + 1], rising; every
/// edge is there from both of its ends.
struct Adjacency {
  PagedArray<std::size_t> begin;
  PagedArray<std::uint32_t> neighbour;

  std::size_t vertices() const { return begin.size() == 0 ? 0 : begin.size() - 1; }
};

/// The edges of a mesh, with the same values at both ends.
struct MeshGraph : Adjacency {
  PagedArray<float> edge_area;    ///< A third of the area of the faces at the edge [unit^2].
  PagedArray<float> vertex_area;  ///< A third of the area of the faces at the vertex [unit^2].
};

/// Makes numbers of items, that of item i at i + 1, the places of the first ones.
void sum_up(PagedArray<std::size_t>& begin);

/// Indices of faces must be in range. Memory and time linear in the size of the mesh.
MeshGraph mesh_graph(const TriangleMesh& mesh);

}  // namespace relief::hybrid
