#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/triangle_mesh.h"

namespace relief::evaluation {

/// A point of a mesh: the weighted mean of a face's corners.
struct SurfaceSample {
  std::uint32_t face = 0;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< Barycentric: >= 0, sum 1.
};

/// `count` points of the surface, each standing for an equal area: the faces in order are cut into
/// `count` strips of equal area with one random point in each. A function of mesh, count and seed
/// alone. Empty when the mesh has no area.
std::vector<SurfaceSample> sample_surface(const TriangleMesh& mesh, std::size_t count,
                                          std::uint64_t seed);

Eigen::Vector3d point_at(const TriangleMesh& mesh, const SurfaceSample& sample);

}  // namespace relief::evaluation
