#pragma once

#include <cstddef>

#include "fusion/isosurface.h"

namespace relief {

/// Splits edges that four faces share. Such an edge arises where two neighbouring cells both
/// triangulate their polygons with the same diagonal of their common face: two sheets cross that
/// edge, and one of them gets a vertex of its own in the middle. The surface must be closed and
/// oriented. Returns the number of edges split; the mesh is edge- and vertex-manifold afterwards.
std::size_t split_shared_diagonals(Isosurface& surface);

}  // namespace relief
