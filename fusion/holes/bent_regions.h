#pragma once

#include <cstdint>
#include <vector>

#include "fusion/holes/fair_regions.h"
#include "fusion/views/view_sampler.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

struct BentRegions {
  TriangleMesh mesh;                ///< With `normals` and `filled`.
  PagedVector<std::uint8_t> moved;  ///< Of the vertices: in a region that was bent.
  double farthest = 0.0;            ///< Move of a vertex [unit].
};

/// Bends the curved filled regions of a mesh (`filled` and `normals` set) of few vertices to where
/// the surface goes on with the slope and the mean curvature it arrives with: steps of (F7), each
/// with the angles, areas and normals of the one before. Slopes may turn by any angle so, while
/// one step holds for small ones. Regions of more than `options.most_bent` vertices stay.
BentRegions bend_filled_regions(TriangleMesh mesh, const std::vector<ViewSampler>& views,
                                const FairFillOptions& options);

}  // namespace relief::fusion
