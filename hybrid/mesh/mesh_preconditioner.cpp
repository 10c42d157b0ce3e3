#include "hybrid/mesh/mesh_preconditioner.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "hybrid/mesh/mesh_aggregates.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kSweep = 4096;            // vertices that one Gauss-Seidel sweep couples
constexpr std::size_t kAggregatesAtOnce = 128;  // of one piece of work; changes no result
// A system of aggregates is solved to this part of its right-hand side, which takes 8 steps. With
// 1e-6 it takes 32, and that of the vertices as many steps as with this.
constexpr double kCoarseTolerance = 1e-2;
// Far more than it takes: the step of vertices is one of an aggregate of them.
constexpr int kMostCoarseSteps = 200;

// Of the factor, its ordering and the system it is made of [bytes per aggregate]. Measured on the
// bear, the bunny and five views of a Kinect (docs/results.md).
constexpr std::size_t kFactorisedAggregate = 1920;

}  // namespace

// The system of the aggregates.
class MeshPreconditioner::Coarse {
 public:
  explicit Coarse(MeshAggregates aggregates) : aggregates_(std::move(aggregates)) {}
  virtual ~Coarse() = default;
  virtual bool update(const MeshMatrix& fine) = 0;
  // Adds P A_coarse^-1 P^T residual.
  void add_correction(const MeshValues& residual, MeshValues& result) const {
    MeshValues sums(aggregates_.size());
    for_aggregates([&](std::size_t a, std::span<const std::uint32_t> members) {
      for (const std::uint32_t i : members) sums[a] += residual[i];
    });
    const MeshValues corrections = solve(sums);
    for_aggregates([&](std::size_t a, std::span<const std::uint32_t> members) {
      for (const std::uint32_t i : members) result[i] += corrections[a];
    });
  }

 protected:
  virtual MeshValues solve(const MeshValues& rhs) const = 0;
  const MeshAggregates& aggregates() const { return aggregates_; }

 private:
  template <typename Visit>
  void for_aggregates(const Visit& visit) const {
    parallel_for(aggregates_.size(), kAggregatesAtOnce, [&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a) visit(a, aggregates_.members(a));
    });
  }

  MeshAggregates aggregates_;
};

class MeshPreconditioner::Factorised : public Coarse {
 public:
  using Coarse::Coarse;

  bool update(const MeshMatrix& fine) override {
    std::vector<Eigen::Triplet<double>> lower;
    AggregateRow row;
    serial_for(aggregates().size(), [&](std::size_t a) {
      find_row(fine, aggregates(), a, row);
      const int here = static_cast<int>(a);
      lower.emplace_back(here, here, row.diagonal);
      for (const AggregateRow::Entry& entry : row.entries)
        if (entry.aggregate < a)
          lower.emplace_back(here, static_cast<int>(entry.aggregate), entry.value);
    });
    const auto size = static_cast<Eigen::Index>(aggregates().size());
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(lower.begin(), lower.end());
    if (!analysed_) factor_.analyzePattern(matrix);
    analysed_ = true;
    factor_.factorize(matrix);
    return factor_.info() == Eigen::Success;
  }

 private:
  MeshValues solve(const MeshValues& rhs) const override {
    const auto size = static_cast<Eigen::Index>(rhs.size());
    MeshValues x(rhs.size());
    Eigen::Map<Eigen::VectorXd>(x.data(), size) =
        factor_.solve(Eigen::Map<const Eigen::VectorXd>(rhs.data(), size));
    return x;
  }

  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
  bool analysed_ = false;
};

class MeshPreconditioner::Iterated : public Coarse {
 public:
  Iterated(const MeshMatrix& fine, MeshAggregates aggregates, std::size_t most_factorised)
      : Coarse(std::move(aggregates)),
        system_(fine, this->aggregates()),
        inverse_(system_.matrix, most_factorised) {}

  bool update(const MeshMatrix& fine) override {
    system_.update(fine, aggregates());
    return inverse_.update();
  }

 private:
  MeshValues solve(const MeshValues& rhs) const override {
    MeshValues x(rhs.size());
    conjugate_gradients([this](const MeshValues& v) { return system_.matrix * v; },
                        [this](const MeshValues& r) { return inverse_(r); }, rhs, kCoarseTolerance,
                        kMostCoarseSteps, x);
    return x;
  }

  AggregateMatrix system_;
  MeshPreconditioner inverse_;
};

MeshPreconditioner::MeshPreconditioner(const MeshMatrix& matrix, std::size_t most_factorised)
    : matrix_(matrix) {
  MeshAggregates aggregates(*matrix.graph);
  // A mesh in many small pieces has as many aggregates.
  const bool fewer = aggregates.size() < matrix.graph->vertices();
  if (aggregates.size() > most_factorised && fewer)
    coarse_ = std::make_unique<Iterated>(matrix, std::move(aggregates), most_factorised);
  else
    coarse_ = std::make_unique<Factorised>(std::move(aggregates));
}

MeshPreconditioner::~MeshPreconditioner() = default;

std::size_t MeshPreconditioner::memory(std::size_t vertices) {
  return kFactorisedAggregate * std::min(vertices / MeshAggregates::kPatch + 1, kMostFactorised);
}

bool MeshPreconditioner::update() { return coarse_->update(matrix_); }

// The two parts are added (additive Schwarz: Dryja and Widlund 1987), so the sum is symmetric.
MeshValues MeshPreconditioner::operator()(const MeshValues& residual) const {
  MeshValues result = gauss_seidel(residual);
  coarse_->add_correction(residual, result);
  return result;
}

MeshValues MeshPreconditioner::gauss_seidel(const MeshValues& residual) const {
  const Adjacency& graph = *matrix_.graph;
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
  parallel_for(graph.vertices(), kSweep, sweep);
  return result;
}

}  // namespace relief::hybrid
