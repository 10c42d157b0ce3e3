#pragma once

#include <Eigen/Core>

#include "hybrid/mesh/mesh_graph.h"
#include "hybrid/mesh/mesh_solver.h"
#include "relief/hybrid/polish_mesh.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/paged_array.h"

namespace relief::hybrid {

struct MeshSystemOptions {
  double sigma_position = 0.0;  ///< Of every vertex [unit]; 0: `quality` of the mesh.
  double sigma_normal = 0.0;    ///< Of every blended normal [rad]; 0: that of the blend.
  /// Error of positions along the surface over that along the normal: sqrt(a / b) of (H13), > 0.
  double tangential = 1.0;
};

using MeshMoves = PagedArray<Eigen::Vector3d>;

/// The least-squares problem of equations (H13) and (H14) on a mesh. Displacements are 3-vectors,
/// one after the other in one vector, or lengths along the normals.
class MeshSystem {
 public:
  /// Keeps references to all arguments.
  MeshSystem(const TriangleMesh& mesh, const MeshGraph& graph, const MeshNormals& normals,
             const MeshSystemOptions& options);

  /// Robust weights (Cauchy) for the residuals that the displacements along the normals, or in
  /// space, leave.
  void reweight(const MeshValues& displacements);

  /// The system in lengths along the vertex normals.
  MeshMatrix normal_matrix() const;
  MeshValues normal_rhs() const;

  /// The system in 3-vectors: its product with `d`, and its right-hand side.
  MeshValues full_product(const MeshValues& d) const;
  MeshValues full_rhs() const;
  /// A preconditioner for it from one for normal_matrix(): normals and tangents apart.
  MeshValues full_precondition(const LinearMap& along_normals, const MeshValues& r) const;

  /// How far two displacements are apart, RMS, in expected errors of the positions.
  double in_errors(const MeshValues& a, const MeshValues& b) const;
  /// Displacements in space, of each vertex.
  MeshMoves in_space(const MeshValues& displacements) const;

 private:
  struct Edge {
    Eigen::Vector3d normal;  // mean along the edge
    double residual;         // normal . (P_j - P_i); 0 where no normals tell
  };
  Edge edge(std::size_t i, std::size_t k) const;  // of vertex i, at k of the graph
  Eigen::Vector3d edge_normal(std::size_t i, std::size_t k) const;
  double angular_variance(std::size_t i, std::size_t k) const;
  double smoothness(std::size_t i, std::size_t k) const;
  double base_weight(std::size_t i, std::size_t k) const;
  Eigen::Vector3d edge_residual(std::size_t i) const;  // of the edges at a vertex
  // Calls visit(vertex) for all, side by side.
  template <typename Visit>
  void for_vertices(const Visit& visit) const;

  const TriangleMesh& mesh_;
  const MeshGraph& graph_;
  MeshSystemOptions options_;
  double sample_area_ = 1.0;
  double samples_ = 0.0;                     // that the vertices stand for
  PagedVector<Eigen::Vector3f> directions_;  // unit: blended normals, or those of the mesh
  PagedArray<Eigen::Vector3f> normals_;      // blended, or those of the mesh where there are none
  const PagedVector<Eigen::Vector3f>* middles_ = nullptr;  // of edges, if there are any
  PagedArray<float> sigma_;                         // of the blended normals [rad]; 0: none there
  MeshValues position_weight_, tangential_weight_;  // a and b of (H13)
  PagedArray<float> weight_;                        // of edges, in the order of graph_
};

}  // namespace relief::hybrid
