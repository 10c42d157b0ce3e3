#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/result.h"
#include "scan/io/clouds/cloud_rays.h"

namespace relief {

/// The regular grid that has about one of the points `at` (coordinates of rays) in each cell. Its
/// axes follow the rows and columns of the points, where they stand in such; steps are the
/// distances to the next point along each axis, which may differ. `turned`: whether the axes may
/// turn from those of the coordinates.
///
/// Points far off from all others (which would make the grid larger than 64 places a point, and a
/// quarter of a million) stay outside it. kUnsolvable when the points lie on a line or are too far
/// apart for their spacing.
Result<CloudLattice> fit_lattice(const std::vector<Eigen::Vector2d>& at, bool turned);

/// The part of the neighbours of points `at` that are whole steps of such a grid away, to a seventh
/// of a step: nearly all on the grid of their own sensor, a tenth elsewhere. 0 without a grid.
double part_on_lattice(const std::vector<Eigen::Vector2d>& at);

}  // namespace relief
