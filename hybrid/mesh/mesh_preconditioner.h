#pragma once

#include <cstddef>
#include <memory>

#include "hybrid/mesh/mesh_solver.h"

namespace relief::hybrid {

/// An approximation of the inverse of a positive definite MeshMatrix: symmetric Gauss-Seidel within
/// ranges of vertices, plus the solution on aggregates of some dozens of vertices. So the number of
/// conjugate gradient steps hardly grows with the mesh. The same on any number of threads.
///
/// The system of few aggregates is factorised. That of more is solved by conjugate gradients with
/// such a preconditioner in turn, so that all but a factor of bounded size lies in paged arrays.
class MeshPreconditioner {
 public:
  static constexpr std::size_t kMostFactorised = 16384;

  /// Keeps a reference to `matrix`, whose values may change until `update`.
  explicit MeshPreconditioner(const MeshMatrix& matrix,
                              std::size_t most_factorised = kMostFactorised);
  ~MeshPreconditioner();

  /// What one for a mesh takes beyond paged arrays, about, with all that polishing does [bytes].
  static std::size_t memory(std::size_t vertices);

  /// Takes up new values of the matrix. False when they are not positive definite.
  bool update();
  MeshValues operator()(const MeshValues& residual) const;

 private:
  class Coarse;
  class Factorised;
  class Iterated;
  MeshValues gauss_seidel(const MeshValues& residual) const;

  const MeshMatrix& matrix_;
  std::unique_ptr<Coarse> coarse_;
};

}  // namespace relief::hybrid
