#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace relief::registration {

struct Sphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0;  ///< >= 0.
};

/// The pairs (i, j), i < j, of spheres that come as near to each other as `margin`, in
/// lexicographic order. A pair that misses it by rounding may be among them. All coordinates are
/// finite.
///
/// Spheres lie in cubic cells by their centres, those of similar size in a lattice of their own.
/// Each sphere asks the cells within its reach in the lattices of its size and below.
std::vector<std::pair<std::size_t, std::size_t>> near_spheres(const std::vector<Sphere>& spheres,
                                                              double margin);

}  // namespace relief::registration
