#include "fusion/holes/plates/large_plate.h"

#include <algorithm>
#include <cmath>

namespace relief::fusion {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

constexpr int kMostSteps = 2000;  // Bounds the time.

// Where the squared error, in the norm of energy, has fallen by so much (1e-10 squared), what is
// left is rounding: of moves of a thousand voxels 1e-7, far below the tolerance of 1e-3.
constexpr double kRounding = 1e-20;

// Conjugate gradients look as if they stood still now and then: only so many small steps on end
// tell that they are done.
constexpr int kSmallSteps = 8;

// The inverse of G W_0^-1 G.
class PoissonTwice {
 public:
  bool prepare(const PlateEquations& equations, MemoryLimit* memory) {
    const Eigen::Index free = equations.attraction.rows();
    const auto area = equations.area.head(free);
    const double least = 1.0 / std::sqrt(static_cast<double>(free));
    compliance_ = equations.weights.head(free).cwiseMax(least * area.cwiseInverse()).cwiseInverse();
    Sparse poisson = Sparse(equations.laplacian.topRows(free)).triangularView<Eigen::Lower>();
    poisson *= -1.0;
    poisson.diagonal() += equations.attraction.cwiseProduct(area).cwiseSqrt();
    factor_.analyzePattern(poisson);
    if (!make_room(memory, factor_.bytes())) return false;
    factor_.factorize(poisson);
    return factor_.info() == Eigen::Success && (factor_.vectorD().array() > 0.0).all();
  }

  Rows3 apply(const Rows3& residual) const {
    const Rows3 inner = compliance_.asDiagonal() * factor_.solve_rows(residual);
    return factor_.solve_rows(inner);
  }

 private:
  SizedFactor factor_;
  Eigen::VectorXd compliance_;  // W_0^-1
};

Rows3 product(const PlateEquations& equations, const Rows3& places) {
  const Rows3 curvature = equations.weights.asDiagonal() * (equations.laplacian * places);
  return equations.laplacian.transpose() * curvature + equations.attraction.asDiagonal() * places;
}

// One number for each of the three coordinates, which are systems of their own.
using Numbers = Eigen::RowVector3d;

Numbers dot(const Rows3& a, const Rows3& b) { return a.cwiseProduct(b).colwise().sum(); }

// Zero where a coordinate has nothing left to do.
Numbers ratio(const Numbers& a, const Numbers& b) {
  return (b.array() > 0.0).select(a.cwiseQuotient(b), Numbers::Zero());
}

}  // namespace

// With P A P^T = L D L^T, L with a unit diagonal, of which m_matrix has what is below.
Rows3 SizedFactor::solve_rows(const Rows3& right) const {
  Rows3 x = m_P * right;
  for (Eigen::Index j = 0; j < x.rows(); ++j) {
    const Eigen::RowVector3d known = x.row(j);
    for (CholMatrixType::InnerIterator entry(m_matrix, j); entry; ++entry)
      if (entry.row() > j) x.row(entry.row()) -= entry.value() * known;
  }
  x = m_diag.cwiseInverse().asDiagonal() * x;
  for (Eigen::Index j = x.rows(); j-- > 0;) {
    Eigen::RowVector3d sum = x.row(j);
    for (CholMatrixType::InnerIterator entry(m_matrix, j); entry; ++entry)
      if (entry.row() > j) sum -= entry.value() * x.row(entry.row());
    x.row(j) = sum;
  }
  return m_Pinv * x;
}

bool approach_plate(const PlateEquations& equations, const LargePlateOptions& options,
                    Rows3& places) {
  PoissonTwice precondition;
  if (!precondition.prepare(equations, options.memory)) return false;
  Rows3 residual = equations.right - product(equations, places);
  Rows3 scaled = precondition.apply(residual), direction = scaled;
  Numbers energy = dot(residual, scaled);
  const Numbers rounding = kRounding * energy;
  int small = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    if (options.keep_going && !options.keep_going()) return false;
    const Rows3 bent = product(equations, direction);
    const Numbers length = ratio(energy, dot(direction, bent));
    const Rows3 move = direction * length.asDiagonal();
    places += move;
    if (!places.allFinite()) return false;
    const bool is_small =
        (move.rowwise().norm().array() * kSmallSteps <= options.tolerance.array()).all();
    small = is_small ? small + 1 : 0;
    if (small >= kSmallSteps) return true;
    residual -= bent * length.asDiagonal();
    scaled = precondition.apply(residual);
    const Numbers before = energy;
    energy = dot(residual, scaled);
    if ((energy.array() <= rounding.array()).all()) return true;
    direction = scaled + direction * ratio(energy, before).asDiagonal();
  }
  return false;
}

}  // namespace relief::fusion
