#pragma once

#include <cstddef>

#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

struct EdgeCollapseOptions {
  std::size_t faces = 0;  ///< Stop when no more are left.
  /// Two vertices become one only where its distance to the planes of all faces that both stand for
  /// has a root of summed squares of at most this [unit].
  double max_error = 0.0;
  /// Move the vertex that is left to where the squares are least, with the attributes of the nearer
  /// one. Else all vertices that are left keep their places.
  bool move = false;
};

/// Removes vertices by joining each with a neighbour, cheapest first by the quadric error (Garland
/// and Heckbert 1997). Closed manifolds stay so, of the same genus and components: an edge goes
/// only when its ends have no common neighbours but the two opposite corners (Dey et al. 1999) and
/// no face turns by more than 60 degrees. Vertices on a border stay. Leaves unused vertices behind.
void collapse_edges(TriangleMesh& mesh, const EdgeCollapseOptions& options);

}  // namespace relief::fusion
