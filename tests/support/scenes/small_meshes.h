#pragma once

#include <algorithm>
#include <cstddef>

#include <Eigen/Core>

#include "relief/scan/triangle_mesh.h"

namespace relief::testing {

/// A tetrahedron of three unlike edges along the axes, with a corner at `at`.
inline TriangleMesh tetrahedron(const Eigen::Vector3d& at = Eigen::Vector3d::Zero()) {
  TriangleMesh mesh;
  mesh.vertices = {at, at + Eigen::Vector3d(1.1, 0, 0), at + Eigen::Vector3d(0, 1.3, 0),
                   at + Eigen::Vector3d(0, 0, 1.7)};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return mesh;
}

/// A mesh of four vertices with all attributes that vertices may have.
inline TriangleMesh with_attributes(TriangleMesh mesh) {
  mesh.normals = vertex_normals(mesh);
  mesh.quality = {0.5f, 1.5f, 2.5f, 3.5f};
  mesh.views = {1, 2, 300, 0};
  mesh.source_views = {0, 7, 300, kNoSourceView};
  mesh.filled = {0, 1, 0, 1};
  mesh.colours = {{1, 2, 3}, {255, 0, 0}, {0, 255, 0}, {0, 0, 255}};
  return mesh;
}

/// Between vertices of the same number.
inline double largest_distance(const TriangleMesh& a, const TriangleMesh& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.vertices.size(); ++i)
    largest = std::max(largest, (a.vertices[i] - b.vertices[i]).norm());
  return largest;
}

}  // namespace relief::testing
