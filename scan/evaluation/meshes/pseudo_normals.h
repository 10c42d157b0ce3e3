#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "scan/mesh/triangle_tree.h"

namespace relief::evaluation {

/// Normals whose dot product with the offset of a point from its closest point on a closed mesh has
/// the sign of the distance, wherever that closest point lies: on a face its normal, on an edge the
/// sum of its faces' normals, at a vertex the sum weighted by the angles of the faces there
/// (Baerentzen and Aanaes 2005). The mesh must outlive this.
class PseudoNormals {
 public:
  explicit PseudoNormals(const TriangleMesh& mesh);

  /// At a point of `face`; not a unit vector.
  Eigen::Vector3d at(std::uint32_t face, const Eigen::Vector3d& weights) const;

 private:
  Eigen::Vector3d unit_normal(std::uint32_t face) const;
  Eigen::Vector3d at_vertex(std::uint32_t vertex) const;
  Eigen::Vector3d at_edge(std::uint32_t a, std::uint32_t b) const;

  const TriangleMesh* mesh_;
  // The faces of vertex i are faces_[begin_[i]] to faces_[begin_[i + 1] - 1].
  std::vector<std::uint32_t> begin_, faces_;
};

}  // namespace relief::evaluation
