#include "scan/evaluation/meshes/pseudo_normals.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace relief::evaluation {

PseudoNormals::PseudoNormals(const TriangleMesh& mesh)
    : mesh_(&mesh), begin_(mesh.vertices.size() + 1, 0), faces_(3 * mesh.faces.size()) {
  for (const auto& face : mesh.faces)
    for (const std::uint32_t vertex : face) ++begin_[vertex + 1];
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
    for (const std::uint32_t vertex : mesh.faces[f]) faces_[next[vertex]++] = f;
}

Eigen::Vector3d PseudoNormals::unit_normal(std::uint32_t face) const {
  return face_cross(*mesh_, face).stableNormalized();
}

Eigen::Vector3d PseudoNormals::at(std::uint32_t face, const Eigen::Vector3d& weights) const {
  const TriangleMesh::Face& corners = mesh_->faces[face];
  for (int k = 0; k < 3; ++k)
    if (weights[k] == 1.0) return at_vertex(corners[k]);
  for (int k = 0; k < 3; ++k)
    if (weights[k] == 0.0) return at_edge(corners[(k + 1) % 3], corners[(k + 2) % 3]);
  return unit_normal(face);
}

Eigen::Vector3d PseudoNormals::at_vertex(std::uint32_t vertex) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const Eigen::Vector3d& centre = mesh_->vertices[vertex];
  for (std::uint32_t i = begin_[vertex]; i < begin_[vertex + 1]; ++i) {
    const TriangleMesh::Face& corners = mesh_->faces[faces_[i]];
    const auto k = std::find(corners.begin(), corners.end(), vertex) - corners.begin();
    const Eigen::Vector3d a = mesh_->vertices[corners[(k + 1) % 3]] - centre;
    const Eigen::Vector3d b = mesh_->vertices[corners[(k + 2) % 3]] - centre;
    sum += std::atan2(a.cross(b).norm(), a.dot(b)) * unit_normal(faces_[i]);
  }
  return sum;
}

Eigen::Vector3d PseudoNormals::at_edge(std::uint32_t a, std::uint32_t b) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::uint32_t i = begin_[a]; i < begin_[a + 1]; ++i) {
    const TriangleMesh::Face& corners = mesh_->faces[faces_[i]];
    if (std::find(corners.begin(), corners.end(), b) != corners.end())
      sum += unit_normal(faces_[i]);
  }
  return sum;
}

}  // namespace relief::evaluation
