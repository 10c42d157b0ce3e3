#pragma once

#include <cstddef>
#include <functional>

#include "hybrid/mesh/mesh_graph.h"
#include "scan/base/memory/paged_array.h"

namespace relief::hybrid {

/// One number for each vertex, or three.
using MeshValues = PagedArray<double>;
MeshValues copy_of(const MeshValues& values);
bool all_finite(const MeshValues& values);

/// A symmetric matrix with one row per vertex and the sparsity of the edges between vertices.
struct MeshMatrix {
  const Adjacency* graph = nullptr;
  MeshValues diagonal;             ///< One per vertex.
  PagedArray<float> off_diagonal;  ///< In the order of graph->neighbour.

  MeshValues operator*(const MeshValues& x) const;
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
