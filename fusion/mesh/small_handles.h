#pragma once

#include <cstddef>

#include <Eigen/Geometry>

#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

/// Handles of a closed mesh that lie within cubes of a size.
struct SmallHandles {
  std::size_t count = 0;
  double area_fraction = 0.0;  ///< Of all, that of the patches in cubes with handles.
  /// Of cubes with handles that touch each other, those with the most handles.
  std::size_t in_region = 0;
  Eigen::AlignedBox3d region;
};

/// Cuts the faces by their centres into cubes of `side` [unit]. Each patch, the faces of a cube
/// that are joined by edges, has a genus of its own. Handles that reach across cubes do not count,
/// so there may be more as small ones. `mesh` is a closed manifold.
SmallHandles find_small_handles(const TriangleMesh& mesh, double side);

}  // namespace relief::fusion
