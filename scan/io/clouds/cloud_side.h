#pragma once

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "scan/io/clouds/cloud_rays.h"

namespace relief {

/// Whether surfaces on a grid turn away from the sensor of parallel rays where they end, at the
/// border of the grid's points and beside steps in depth: positive if they do. A solid object does
/// so seen from its sensor: there its outlines are. Seen from behind, the value has the other sign.
/// It is the mean slope there along the rays, each at most 3 in size. 0 without a
/// sample. Points are NaN where there is no sample; `spacing` is that of the grid [unit].
double turning_away(const Grid<Eigen::Vector3d>& points, const CloudRays& rays, double spacing);

}  // namespace relief
