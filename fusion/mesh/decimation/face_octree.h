#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/paged_array.h"

namespace relief::fusion {

/// A cube with the faces whose centres lie in it.
struct FaceCube {
  Eigen::Vector3d centre;
  double half_side = 0.0;
  std::size_t begin = 0, end = 0;     ///< Its faces in FaceOctree::faces.
  std::size_t depth = 0;              ///< 0: the root.
  std::vector<std::size_t> children;  ///< Only those with faces; none: it was not divided.
};

/// The faces of a mesh in an octree of cubes.
struct FaceOctree {
  std::vector<FaceCube> cubes;      ///< The root first; the deeper ones come later.
  PagedArray<std::uint32_t> faces;  ///< Those of a cube lie together.
};

/// Divides cubes until each has at most `most_faces`. A mesh without faces has one empty cube.
FaceOctree divide_faces(const TriangleMesh& mesh, std::size_t most_faces);

}  // namespace relief::fusion
