#include "hybrid/mesh/mesh_solver.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

// Both make the preconditioner: they change the number of steps, not what is minimised.
constexpr std::size_t kRange = 4096;  // vertices that one Gauss-Seidel sweep couples
// Vertices of an aggregate: of 2 million the direct solve has 42 thousand.
constexpr std::size_t kAggregate = 48;
constexpr std::uint32_t kNone = 0xffffffffu;

// Breadth-first patches of up to kAggregate vertices. What is cut off between patches joins the
// patch of a neighbour.
PagedArray<std::uint32_t> aggregates(const MeshGraph& graph) {
  PagedArray<std::uint32_t> aggregate(graph.vertices());
  serial_for(graph.vertices(), [&](std::size_t v) { aggregate[v] = kNone; });
  std::vector<std::uint32_t> patch;
  std::uint32_t count = 0;
  serial_for(graph.vertices(), [&](std::size_t seed) {
    if (aggregate[seed] != kNone) return;
    aggregate[seed] = count;
    patch.assign(1, static_cast<std::uint32_t>(seed));
    std::uint32_t beside = kNone;
    for (std::size_t next = 0; next < patch.size(); ++next) {
      const std::uint32_t v = patch[next];
      for (std::size_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
        const std::uint32_t other = graph.neighbour[k];
        if (aggregate[other] == kNone && patch.size() < kAggregate) {
          aggregate[other] = count;
          patch.push_back(other);
        } else if (aggregate[other] < count) {
          beside = aggregate[other];
        }
      }
    }
    if (patch.size() < kAggregate / 4 && beside != kNone)
      for (const std::uint32_t v : patch) aggregate[v] = beside;
    else
      ++count;
  });
  return aggregate;
}

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

struct MeshPreconditioner::Coarse {
  Eigen::Index size = 0;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor;
  bool analysed = false;
};

MeshPreconditioner::MeshPreconditioner(const MeshMatrix& matrix)
    : matrix_(matrix), aggregate_(aggregates(*matrix.graph)), coarse_(std::make_unique<Coarse>()) {
  serial_for(aggregate_.size(), [&](std::size_t i) {
    coarse_->size = std::max(coarse_->size, static_cast<Eigen::Index>(aggregate_[i]) + 1);
  });
  // Until all members are there, the beginning of an aggregate is one place farther.
  first_ = PagedArray<std::uint32_t>(static_cast<std::size_t>(coarse_->size) + 2);
  serial_for(aggregate_.size(), [&](std::size_t i) { ++first_[aggregate_[i] + 2]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  member_ = PagedArray<std::uint32_t>(aggregate_.size());
  serial_for(aggregate_.size(), [&](std::size_t i) {
    member_[first_[aggregate_[i] + 1]++] = static_cast<std::uint32_t>(i);
  });
}

MeshPreconditioner::~MeshPreconditioner() = default;

bool MeshPreconditioner::update() {
  const MeshGraph& graph = *matrix_.graph;
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> diagonal(static_cast<std::size_t>(coarse_->size), 0.0);
  serial_for(graph.vertices(), [&](std::size_t i) {
    const std::uint32_t a = aggregate_[i];
    diagonal[a] += matrix_.diagonal[i];
    for (std::size_t k = graph.begin[i]; k < graph.begin[i + 1]; ++k) {
      const std::uint32_t b = aggregate_[graph.neighbour[k]];
      if (a == b)
        diagonal[a] += double{matrix_.off_diagonal[k]};
      else if (a > b)
        entries.emplace_back(a, b, double{matrix_.off_diagonal[k]});
    }
  });
  for (std::size_t a = 0; a < diagonal.size(); ++a)
    entries.emplace_back(static_cast<int>(a), static_cast<int>(a), diagonal[a]);
  Eigen::SparseMatrix<double> lower(coarse_->size, coarse_->size);
  lower.setFromTriplets(entries.begin(), entries.end());
  if (!coarse_->analysed) coarse_->factor.analyzePattern(lower);
  coarse_->analysed = true;
  coarse_->factor.factorize(lower);
  return coarse_->factor.info() == Eigen::Success;
}

// The two parts are added (additive Schwarz: Dryja and Widlund 1987), so the sum is symmetric.
MeshValues MeshPreconditioner::operator()(const MeshValues& residual) const {
  const MeshGraph& graph = *matrix_.graph;
  MeshValues result(residual.size());
  const auto sweep = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double sum = residual[i];
      for (std::size_t k = graph.begin[i]; k < graph.begin[i + 1]; ++k) {
        const std::uint32_t j = graph.neighbour[k];
        if (j >= i) break;
        if (j >= begin) sum -= double{matrix_.off_diagonal[k]} * result[j];
      }
      result[i] = sum / matrix_.diagonal[i];
    }
    for (std::size_t i = end; i-- > begin;) {
      double sum = 0.0;
      for (std::size_t k = graph.begin[i + 1]; k-- > graph.begin[i];) {
        const std::uint32_t j = graph.neighbour[k];
        if (j <= i) break;
        if (j < end) sum += double{matrix_.off_diagonal[k]} * result[j];
      }
      result[i] -= sum / matrix_.diagonal[i];
    }
  };
  parallel_for(graph.vertices(), kRange, sweep);

  Eigen::VectorXd coarse(coarse_->size);
  const auto for_aggregates = [&](const auto& visit) {
    parallel_for(static_cast<std::size_t>(coarse_->size), kRange, [&](std::size_t begin, auto end) {
      for (std::size_t a = begin; a < end; ++a)
        visit(static_cast<Eigen::Index>(a),
              member_.span().subspan(first_[a], first_[a + 1] - first_[a]));
    });
  };
  for_aggregates([&](Eigen::Index a, std::span<const std::uint32_t> members) {
    coarse[a] = 0.0;
    for (const std::uint32_t i : members) coarse[a] += residual[i];
  });
  coarse = coarse_->factor.solve(coarse).eval();
  for_aggregates([&](Eigen::Index a, std::span<const std::uint32_t> members) {
    for (const std::uint32_t i : members) result[i] += coarse[a];
  });
  return result;
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
