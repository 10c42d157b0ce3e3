#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/paged_array.h"

namespace relief {

/// The components of a mesh (faces connected through common vertices), by their first vertices.
struct MeshComponents {
  PagedArray<std::uint32_t> of_vertex;  ///< Vertices without a face are a component each.
  std::vector<double> area;             ///< Of each [unit^2].
  std::vector<std::size_t> faces;       ///< Of each.

  std::size_t count() const { return area.size(); }
};

MeshComponents find_components(const TriangleMesh& mesh);

/// What was taken away.
struct RemovedComponents {
  std::size_t components = 0;
  std::size_t faces = 0;
  double area_fraction = 0.0;  ///< Of the area of all faces.
};

/// Keeps the components with `kept` set, with their attributes; order is kept. Vertices without a
/// face go as well, and count as no component.
RemovedComponents keep_components(const MeshComponents& components, const std::vector<bool>& kept,
                                  TriangleMesh& mesh);

/// Keeps the component of the largest area, ties going to the first.
RemovedComponents keep_largest_component(TriangleMesh& mesh);

/// Drops the vertices no face uses, with their attributes; order is kept.
void drop_unused_vertices(TriangleMesh& mesh);

}  // namespace relief
