#pragma once

#include <algorithm>
#include <cstddef>

#include <Eigen/Geometry>

#include "fusion/tsdf/tsdf_integration.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

/// The box of the vertices [begin, end) of a mesh.
inline Eigen::AlignedBox3d box_of(const TriangleMesh& mesh, std::size_t begin, std::size_t end) {
  Eigen::AlignedBox3d box;
  for (std::size_t v = begin; v < end; ++v) box.extend(mesh.vertices[v]);
  return box;
}

/// Calls visit(v) for the vertices [begin, end) of a mesh, some thousands at most. `collector` then
/// asks only the views that have something to say near v: all views are looked at once for all of
/// the vertices, those that are left once for each group. Vertices of near indices are near each
/// other in an extracted mesh. In others the result is the same, in more time.
template <typename Visit>
void visit_in_groups(const TriangleMesh& mesh, std::size_t begin, std::size_t end,
                     TsdfIntegrator& collector, const Visit& visit) {
  constexpr std::size_t kGroup = 128;  // About the vertices of one block of the field.
  collector.narrow(box_of(mesh, begin, end));
  for (std::size_t first = begin; first < end; first += kGroup) {
    const std::size_t last = std::min(first + kGroup, end);
    collector.focus(box_of(mesh, first, last));
    for (std::size_t v = first; v < last; ++v) visit(v);
  }
}

}  // namespace relief::fusion
