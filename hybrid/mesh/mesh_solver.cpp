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
PagedVector<std::uint32_t> aggregates(const MeshGraph& graph) {
  PagedVector<std::uint32_t> aggregate(graph.vertices(), kNone);
  std::vector<std::uint32_t> patch;
  std::uint32_t count = 0;
  for (std::size_t seed = 0; seed < graph.vertices(); ++seed) {
    if (aggregate[seed] != kNone) continue;
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
  }
  return aggregate;
}

}  // namespace

Eigen::VectorXd MeshMatrix::operator*(const Eigen::VectorXd& x) const {
  Eigen::VectorXd y(x.size());
  parallel_for(diagonal.size(), kRange, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double sum = diagonal[i] * x[static_cast<Eigen::Index>(i)];
      for (std::size_t k = graph->begin[i]; k < graph->begin[i + 1]; ++k)
        sum += double{off_diagonal[k]} * x[graph->neighbour[k]];
      y[static_cast<Eigen::Index>(i)] = sum;
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
  for (const std::uint32_t a : aggregate_)
    coarse_->size = std::max(coarse_->size, static_cast<Eigen::Index>(a) + 1);
  PagedVector<std::uint32_t> next(static_cast<std::size_t>(coarse_->size) + 1, 0);
  for (const std::uint32_t a : aggregate_) ++next[a + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  first_ = next;
  member_.resize(aggregate_.size());
  for (std::uint32_t i = 0; i < aggregate_.size(); ++i) member_[next[aggregate_[i]]++] = i;
}

MeshPreconditioner::~MeshPreconditioner() = default;

bool MeshPreconditioner::update() {
  const MeshGraph& graph = *matrix_.graph;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(aggregate_.size());
  std::vector<double> diagonal(static_cast<std::size_t>(coarse_->size), 0.0);
  for (std::size_t i = 0; i < graph.vertices(); ++i) {
    const std::uint32_t a = aggregate_[i];
    diagonal[a] += matrix_.diagonal[i];
    for (std::size_t k = graph.begin[i]; k < graph.begin[i + 1]; ++k) {
      const std::uint32_t b = aggregate_[graph.neighbour[k]];
      if (a == b)
        diagonal[a] += double{matrix_.off_diagonal[k]};
      else if (a > b)
        entries.emplace_back(a, b, double{matrix_.off_diagonal[k]});
    }
  }
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
Eigen::VectorXd MeshPreconditioner::operator()(const Eigen::VectorXd& residual) const {
  const MeshGraph& graph = *matrix_.graph;
  Eigen::VectorXd result(residual.size());
  const auto at = [](std::size_t i) { return static_cast<Eigen::Index>(i); };
  const auto sweep = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double sum = residual[at(i)];
      for (std::size_t k = graph.begin[i]; k < graph.begin[i + 1]; ++k) {
        const std::uint32_t j = graph.neighbour[k];
        if (j >= i) break;
        if (j >= begin) sum -= double{matrix_.off_diagonal[k]} * result[j];
      }
      result[at(i)] = sum / matrix_.diagonal[i];
    }
    for (std::size_t i = end; i-- > begin;) {
      double sum = 0.0;
      for (std::size_t k = graph.begin[i + 1]; k-- > graph.begin[i];) {
        const std::uint32_t j = graph.neighbour[k];
        if (j <= i) break;
        if (j < end) sum += double{matrix_.off_diagonal[k]} * result[j];
      }
      result[at(i)] -= sum / matrix_.diagonal[i];
    }
  };
  parallel_for(graph.vertices(), kRange, sweep);

  Eigen::VectorXd coarse(coarse_->size);
  const auto for_aggregates = [&](const auto& visit) {
    parallel_for(first_.size() - 1, kRange, [&](std::size_t begin, auto end) {
      for (std::size_t a = begin; a < end; ++a)
        visit(at(a), std::span(member_).subspan(first_[a], first_[a + 1] - first_[a]));
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

// Sums of ranges, in their order.
double dot(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return parallel_sum(static_cast<std::size_t>(a.size()), kRange, 0.0,
                      [&](std::size_t begin, std::size_t end) {
                        const auto first = static_cast<Eigen::Index>(begin);
                        const auto count = static_cast<Eigen::Index>(end - begin);
                        return a.segment(first, count).dot(b.segment(first, count));
                      });
}

// y = scale y + factor x.
void combine(double scale, Eigen::VectorXd& y, double factor, const Eigen::VectorXd& x) {
  parallel_for(static_cast<std::size_t>(y.size()), kRange, [&](std::size_t begin, std::size_t end) {
    const auto first = static_cast<Eigen::Index>(begin);
    const auto count = static_cast<Eigen::Index>(end - begin);
    y.segment(first, count) = scale * y.segment(first, count) + factor * x.segment(first, count);
  });
}

}  // namespace

ConjugateGradients conjugate_gradients(const LinearMap& matrix, const LinearMap& preconditioner,
                                       const Eigen::VectorXd& rhs, double tolerance,
                                       int max_iterations, Eigen::VectorXd& x) {
  const double goal = tolerance * tolerance * dot(rhs, preconditioner(rhs));
  Eigen::VectorXd residual = rhs - matrix(x);
  Eigen::VectorXd preconditioned = preconditioner(residual);
  Eigen::VectorXd direction = preconditioned;
  double energy = dot(residual, preconditioned);
  ConjugateGradients solve;
  while (energy > goal && solve.iterations < max_iterations) {
    const Eigen::VectorXd image = matrix(direction);
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
