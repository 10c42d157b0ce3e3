#pragma once

#include <algorithm>
#include <cstddef>

#include <Eigen/Geometry>

#include "fusion/tsdf/tsdf_integration.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

/// Calls visit(v) for the vertices [begin, end) of a mesh. `collector` then asks only the views
/// that have something to say near v: all views are looked at once for each group, not for each
/// vertex. Vertices of near indices are near each other in an extracted mesh. In others the result
/// is the same, in more time.
template <typename Visit>
void visit_in_groups(const TriangleMesh& mesh, std::size_t begin, std::size_t end,
                     TsdfIntegrator& collector, const Visit& visit) {
  constexpr std::size_t kGroup = 128;  // About the vertices of one block of the field.
  for (std::size_t first = begin; first < end; first += kGroup) {
    const std::size_t last = std::min(first + kGroup, end);
    Eigen::AlignedBox3d box;
    for (std::size_t v = first; v < last; ++v) box.extend(mesh.vertices[v]);
    collector.focus(box);
    for (std::size_t v = first; v < last; ++v) visit(v);
  }
}

}  // namespace relief::fusion
