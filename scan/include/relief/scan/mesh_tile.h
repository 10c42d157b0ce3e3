#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

namespace relief {

/// A tile of a mesh in several levels of detail, which form a tree: all children of a tile together
/// show the same part of the surface in more detail.
struct MeshTile {
  Eigen::AlignedBox3d box;            ///< Of the vertices of the tile and of those below it.
  double edge_length = 0.0;           ///< Mean over its surface [unit].
  std::size_t faces = 0;              ///< Of the tile itself.
  std::vector<std::size_t> children;  ///< By their numbers; none where the mesh is as given.
};

}  // namespace relief
