#pragma once

#include <Eigen/Core>

namespace relief {

/// On which side of the plane through a, b and c the point p is: 1 where (b - a) x (c - a) points
/// to, -1 opposite, 0 in the plane or when a, b and c are collinear. Exact for the given doubles
/// unless a product of three coordinate differences over- or underflows.
int side_of_plane(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                  const Eigen::Vector3d& p);

/// On which side of the directed line from a to b the point p is: 1 left, -1 right, 0 on it. Exact
/// in the same sense.
int side_of_line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p);

}  // namespace relief
