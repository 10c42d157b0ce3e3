#pragma once

#include <Eigen/Core>

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"

namespace relief::registration {

struct UnbiasedNormalOptions {
  /// Half width [pixels] of the window over which the bias of the normals is taken as constant. 0:
  /// the smallest whose positions tell the mean slope to a quarter of a degree at `noise`.
  int radius = 0;
  double noise = 0.0;    ///< Of positions along the normal, standard deviation [unit].
  double spacing = 0.0;  ///< Of the samples [unit].
};

/// The measured normals without their smooth bias: each is turned so that over the window round it
/// the normals explain, on average, the steps between the measured positions, (R8). What is finer
/// than the window comes from the normals, what is coarser from the positions, as by Nehab et al.
/// (2005), section 4.1. NaN where a view has no normal or the window hardly any sample.
Grid<Eigen::Vector3f> unbiased_normals(const RangeView& view, const GridEdges& edges,
                                       const UnbiasedNormalOptions& options);

}  // namespace relief::registration
