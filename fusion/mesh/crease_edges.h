#pragma once

#include <cstddef>

#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

struct CreaseEdgeOptions {
  double voxel_size = 0.0;  ///< About the length of an edge [unit].
  double noise = 0.0;       ///< Standard deviation of a view's positions [unit].
};

/// Turns edges that cut across creases: of the two diagonals of a pair of faces, the one is taken
/// that the surface leaves less, by the normals at its ends. Vertices stay, and so do closedness,
/// manifoldness and genus; no face turns by more than 60 degrees from the mean of its pair, becomes
/// thinner than a sliver, or comes to intersect others. `normals` are renewed. Returns how many
/// edges were turned.
std::size_t align_edges_with_creases(TriangleMesh& mesh, const CreaseEdgeOptions& options);

}  // namespace relief::fusion
