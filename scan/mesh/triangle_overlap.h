#pragma once

#include <array>

#include <Eigen/Core>

namespace relief {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// Whether the three corners are exactly on one line.
bool collinear(const Triangle& triangle);

/// Whether two triangles have a point in common that is not on a corner or an edge that they share.
/// Corners are shared when they are at exactly the same place. Triangles that touch otherwise, lie
/// over each other in one plane, or are the same do overlap. Exact (see exact_predicates.h);
/// neither may have collinear corners.
bool overlap(const Triangle& first, const Triangle& second);

}  // namespace relief
