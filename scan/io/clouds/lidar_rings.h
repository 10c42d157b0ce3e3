#pragma once

#include <vector>

#include <Eigen/Core>

namespace relief {

/// Whether points lie on cones about z with their tip at the origin, some tenths of a degree or
/// more apart: each laser of a spinning lidar stands at an elevation of its own. So it is where a
/// cloud was thinned, as long as the points that are left were not moved.
bool on_lidar_rings(const std::vector<Eigen::Vector3d>& points);

}  // namespace relief
