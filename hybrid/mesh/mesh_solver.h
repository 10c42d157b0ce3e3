#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "hybrid/mesh/mesh_graph.h"
#include "scan/base/memory/paged_array.h"

namespace relief::hybrid {

/// One number for each vertex, or three.
using MeshValues = PagedArray<double>;
MeshValues copy_of(const MeshValues& values);
bool all_finite(const MeshValues& values);

/// A symmetric matrix with one row per vertex and the sparsity of a mesh's edges.
struct MeshMatrix {
  const MeshGraph* graph = nullptr;
  MeshValues diagonal;             ///< One per vertex.
  PagedArray<float> off_diagonal;  ///< In the order of graph->neighbour.

  MeshValues operator*(const MeshValues& x) const;
};

/// A fixed approximation of the inverse of a positive definite MeshMatrix: symmetric Gauss-Seidel
/// within ranges of vertices, plus a direct solve on aggregates of some dozens of vertices, whose
/// number of conjugate gradient steps hardly grows with the mesh. The same on any number of
/// threads.
class MeshPreconditioner {
 public:
  /// Keeps a reference to `matrix`, whose values may change until `update`.
  explicit MeshPreconditioner(const MeshMatrix& matrix);
  ~MeshPreconditioner();

  /// Takes up new values of the matrix. False when they are not positive definite.
  bool update();
  MeshValues operator()(const MeshValues& residual) const;

 private:
  struct Coarse;
  const MeshMatrix& matrix_;
  PagedArray<std::uint32_t> aggregate_;  // of each vertex
  // The vertices of aggregate a, ascending: member_[first_[a]] to member_[first_[a + 1]].
  PagedArray<std::uint32_t> first_, member_;
  std::unique_ptr<Coarse> coarse_;
};

using LinearMap = std::function<MeshValues(const MeshValues&)>;

struct ConjugateGradients {
  bool converged = false;
  int iterations = 0;
};

/// Preconditioned conjugate gradients (Hestenes and Stiefel 1952) from `x`, where the solution is
/// left, until the preconditioned residual is below `tolerance` times that of x = 0. The same on
/// any number of threads if both maps are.
ConjugateGradients conjugate_gradients(const LinearMap& matrix, const LinearMap& preconditioner,
                                       const MeshValues& rhs, double tolerance, int max_iterations,
                                       MeshValues& x);

}  // namespace relief::hybrid
