#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "relief/scan/triangle_mesh.h"

namespace relief::hybrid {

struct GuardedMove {
  PagedVector<Eigen::Vector3d> vertices;  ///< Where the vertices may go.
  std::size_t damped = 0;                 ///< Vertices that moved less than asked.
  std::size_t unmoved = 0;                ///< Of these, the ones that did not move at all.
  int rounds = 0;                         ///< Of checking and halving.
};

/// Moves the vertices of `mesh` by `displacements` (one each) as far as every face stays sound
/// and no two faces come to intersect. A face is sound when it turns by less than 90 degrees, turns
/// by less than 60 or ends within 60 of the surface around it, and keeps a hundredth of its area.
/// Around faces for which that would fail the displacements are halved until it does not, in the
/// end to nothing; what intersects in `mesh` itself stays as it is.
GuardedMove guarded_move(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> displacements);

}  // namespace relief::hybrid
