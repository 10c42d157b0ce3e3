#pragma once

#include <cstddef>
#include <functional>

#include <Eigen/Core>

#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

struct HandleRemovalOptions {
  double side = 0.0;        ///< Handles within cubes of this side count as small [unit].
  double voxel_size = 0.0;  ///< About the length of an edge [unit].
  /// Makes a test, for one thread, of whether a view saw that there is nothing at a point.
  std::function<std::function<bool(const Eigen::Vector3d&)>()> emptiness;
};

/// Removes small handles of a closed mesh (`filled` set) that nobody measured, and returns how many
/// (topological noise: Guskov and Wood 2001). Of a loop round or through such a handle half of the
/// vertices or more are filled. The mesh is cut there, and either side is closed by a membrane that
/// spans the faces beside the loop. Handles stay where a membrane would lie in space that a view
/// saw empty, or the surface would intersect itself. All attributes of new vertices are those of a
/// vertex of the loop.
std::size_t remove_unmeasured_handles(TriangleMesh& mesh, const HandleRemovalOptions& options);

}  // namespace relief::fusion
