#pragma once

#include <cstddef>
#include <functional>

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "fusion/memory/memory_limit.h"

namespace relief::fusion {

/// Three coordinates for each of some vertices, side by side in memory.
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// A factorisation that knows, before the numbers, how many there will be.
class SizedFactor : public Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> {
 public:
  std::size_t bytes() const {
    constexpr std::size_t kEntry = sizeof(double) + sizeof(StorageIndex);
    return kEntry * static_cast<std::size_t>(m_matrix.data().size());
  }

  /// The solution for three right sides at once. The factor is read once, where solve() reads it
  /// for each right side anew: reading it is what takes the time.
  Rows3 solve_rows(const Rows3& right) const;
};

/// The system of a thin plate (F7), with one row for each free vertex and then for each held one:
///
///   (L^T W L + Q) x = right
///
/// L takes free vertices to the curvature at all of these, W is diagonal (stiffness over area), Q
/// too (attraction times area).
struct PlateEquations {
  const Eigen::SparseMatrix<double>& laplacian;  ///< L; its free part is negative definite.
  const Eigen::VectorXd &weights, &area;         ///< Of all rows.
  const Eigen::VectorXd& attraction;             ///< Q, of the free ones.
  Rows3 right;
};

struct LargePlateOptions {
  Eigen::VectorXd tolerance;         ///< Of the places of the free vertices [unit].
  MemoryLimit* memory = nullptr;     ///< May be null.
  std::function<bool()> keep_going;  ///< Asked between steps; may be empty.
};

/// Solves for the places x of a plate with so many vertices that the factors of its system would
/// take too much memory, from the places given: conjugate gradients, preconditioned by the two
/// Poisson problems that a plate with hinged borders is made of (Ciarlet and Raviart 1974),
///
///   G W_0^-1 G,  G = -L + (A Q)^1/2,  W_0 = max(W, n^-1/2 / A),
///
/// over the n free vertices. G alone is factorised: it has 7 entries in a row where the system has
/// 19. Ends when steps move no vertex by more than a part of its tolerance.
/// False: singular, not converged, told to stop, or `memory` cannot be kept.
bool approach_plate(const PlateEquations& equations, const LargePlateOptions& options,
                    Rows3& places);

}  // namespace relief::fusion
