#include "hybrid/mesh/mesh_solver.h"

#include <cmath>

#include <Eigen/Core>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kRange = 4096;  // vertices of one piece of work; changes sums by rounding

}  // namespace

MeshValues MeshMatrix::operator*(const MeshValues& x) const {
  MeshValues y(x.size());
  parallel_for(diagonal.size(), kRange, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double sum = diagonal[i] * x[i];
      for (std::size_t k = graph->begin[i]; k < graph->begin[i + 1]; ++k)
        sum += double{off_diagonal[k]} * x[graph->neighbour[k]];
      y[i] = sum;
    }
  });
  return y;
}

namespace {

// The values from `begin` to `end`.
Eigen::Map<const Eigen::VectorXd> part(const MeshValues& values, std::size_t begin,
                                       std::size_t end) {
  return {values.data() + begin, static_cast<Eigen::Index>(end - begin)};
}

// Sums of ranges, in their order.
double dot(const MeshValues& a, const MeshValues& b) {
  return parallel_sum(a.size(), kRange, 0.0, [&](std::size_t begin, std::size_t end) {
    return part(a, begin, end).dot(part(b, begin, end));
  });
}

// y = scale y + factor x.
void combine(double scale, MeshValues& y, double factor, const MeshValues& x) {
  parallel_for(y.size(), kRange, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) y[i] = scale * y[i] + factor * x[i];
  });
}

}  // namespace

MeshValues copy_of(const MeshValues& values) {
  MeshValues copy(values.size());
  combine(0.0, copy, 1.0, values);
  return copy;
}

bool all_finite(const MeshValues& values) {
  const auto finite = [&](std::size_t begin, std::size_t end) {
    return part(values, begin, end).allFinite() ? 1 : 0;
  };
  const std::size_t parts = (values.size() + kRange - 1) / kRange;
  return parallel_sum<std::size_t>(values.size(), kRange, 0, finite) == parts;
}

ConjugateGradients conjugate_gradients(const LinearMap& matrix, const LinearMap& preconditioner,
                                       const MeshValues& rhs, double tolerance, int max_iterations,
                                       MeshValues& x) {
  const double goal = tolerance * tolerance * dot(rhs, preconditioner(rhs));
  MeshValues residual = matrix(x);
  combine(-1.0, residual, 1.0, rhs);
  MeshValues preconditioned = preconditioner(residual);
  MeshValues direction = copy_of(preconditioned);
  double energy = dot(residual, preconditioned);
  ConjugateGradients solve;
  while (energy > goal && solve.iterations < max_iterations) {
    const MeshValues image = matrix(direction);
    const double step = energy / dot(direction, image);
    if (!std::isfinite(step)) return solve;
    combine(1.0, x, step, direction);
    combine(1.0, residual, -step, image);
    preconditioned = preconditioner(residual);
    const double next = dot(residual, preconditioned);
    combine(next / energy, direction, 1.0, preconditioned);
    energy = next;
    ++solve.iterations;
  }
  solve.converged = energy <= goal;
  return solve;
}

}  // namespace relief::hybrid
