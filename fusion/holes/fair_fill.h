#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "fusion/holes/fair_regions.h"
#include "fusion/views/view_sampler.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

struct FairFill {
  PagedVector<Eigen::Vector3d> places;  ///< Of all vertices; empty when none moves.
  std::size_t unsolved = 0;   ///< Regions that stay as they are since no plate was found for them.
  std::size_t too_large = 0;  ///< Regions that stay as they are since they are too large for one.
  bool near_samples = false;  ///< Whether any region has FairRegion::near_samples.
};

/// Places for the filled vertices of a merged mesh (`filled` and `normals` set), with which the
/// surface goes on across the border of what was measured with the slope it arrives with, or, where
/// the closed field left it at a sharp angle, spans the border plainly. It stays out of space that
/// a view saw empty, or leaves it where it can, and intersects itself nowhere it did not.
/// Errors: kInterrupted, and what `options.memory` tells when it cannot be kept.
Result<FairFill> fair_filled_regions(const TriangleMesh& mesh,
                                     const std::vector<ViewSampler>& views,
                                     const FairFillOptions& options, const Progress& progress = {});

}  // namespace relief::fusion
