#pragma once

#include <cstddef>

#include "relief/scan/triangle_mesh.h"

namespace relief {

/// What keep_largest_component took away.
struct RemovedComponents {
  std::size_t components = 0;
  std::size_t faces = 0;
  double area_fraction = 0.0;  ///< Of the area of all faces.
};

/// Keeps the component (faces connected through common vertices) of the largest area, ties going to
/// the first, with its attributes; order is kept. Vertices without a face go as well.
RemovedComponents keep_largest_component(TriangleMesh& mesh);

/// Drops the vertices no face uses, with their attributes; order is kept.
void drop_unused_vertices(TriangleMesh& mesh);

}  // namespace relief
