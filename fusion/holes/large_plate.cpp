#include "fusion/holes/large_plate.h"

#include <algorithm>
#include <cmath>

namespace relief::fusion {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

constexpr int kMostSteps = 2000;

// Where the squared error, in the norm of energy, has fallen by so much, what is left is rounding.
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
    evict_pages(memory, factor_.bytes());
    if (!check(memory)) return false;
    factor_.factorize(poisson);
    return factor_.info() == Eigen::Success && (factor_.vectorD().array() > 0.0).all();
  }

  Eigen::MatrixX3d apply(const Eigen::MatrixX3d& residual) const {
    const Eigen::MatrixX3d inner = compliance_.asDiagonal() * factor_.solve(residual);
    return factor_.solve(inner);
  }

 private:
  SizedFactor factor_;
  Eigen::VectorXd compliance_;  // W_0^-1
};

Eigen::MatrixX3d product(const PlateEquations& equations, const Eigen::MatrixX3d& places) {
  const Eigen::MatrixX3d curvature =
      equations.weights.asDiagonal() * (equations.laplacian * places);
  return equations.laplacian.transpose() * curvature + equations.attraction.asDiagonal() * places;
}

// One number for each of the three coordinates, which are systems of their own.
using Numbers = Eigen::RowVector3d;

Numbers dot(const Eigen::MatrixX3d& a, const Eigen::MatrixX3d& b) {
  return a.cwiseProduct(b).colwise().sum();
}

// Zero where a coordinate has nothing left to do.
Numbers ratio(const Numbers& a, const Numbers& b) {
  return (b.array() > 0.0).select(a.cwiseQuotient(b), Numbers::Zero());
}

}  // namespace

bool approach_plate(const PlateEquations& equations, double tolerance, MemoryLimit* memory,
                    Eigen::MatrixX3d& places) {
  PoissonTwice precondition;
  if (!precondition.prepare(equations, memory)) return false;
  Eigen::MatrixX3d residual = equations.right - product(equations, places);
  Eigen::MatrixX3d scaled = precondition.apply(residual), direction = scaled;
  Numbers energy = dot(residual, scaled);
  const Numbers rounding = kRounding * energy;
  int small = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::MatrixX3d bent = product(equations, direction);
    const Numbers length = ratio(energy, dot(direction, bent));
    const Eigen::MatrixX3d move = direction * length.asDiagonal();
    places += move;
    if (!places.allFinite()) return false;
    const double largest = std::sqrt(move.rowwise().squaredNorm().maxCoeff());
    small = largest * kSmallSteps <= tolerance ? small + 1 : 0;
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
