#pragma once

#include <vector>

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"

namespace relief {

/// A window of a view in which both the surface and the stored normals have a mean direction.
struct NormalPatch {
  Eigen::Vector3d surface;  ///< Unit normal of the plane through the samples, facing the sensor.
  Eigen::Vector3d stored;   ///< Mean of the stored directions as unit vector, as stored.
  double stddev = 0.0;      ///< Of `surface` about a tangent axis [rad].
};

/// Patches on a lattice of windows that share no sample.
struct NormalPatches {
  std::vector<NormalPatch> patches;
  Grid<int> lattice;  ///< Index of the patch at a place of the lattice, -1 where there is none.
  int radius = 0;     ///< Half width of the windows [pixels].
  int step = 1;       ///< Width of a place of the lattice [pixels].
};

/// Compares the depth of `view` with directions `stored` on its grid (any length; NaN: none). The
/// windows are as small as the noise of the depth allows for normals good to a few degrees. At most
/// some thousand patches.
NormalPatches find_patches(const RangeView& view, const Grid<Eigen::Vector3f>& stored);

}  // namespace relief
