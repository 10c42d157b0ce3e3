#include "fusion/holes/plates/thin_plate.h"

#include <unordered_map>

#include <Eigen/CholmodSupport>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// What a system takes without its factor, for each free vertex [bytes].
constexpr std::size_t kSystem = 1000;

// Unknowns of a system whose factor is large against what was needed to set it up. Changes memory
// and no result.
constexpr Eigen::Index kLarge = 10000;

using Sparse = Eigen::SparseMatrix<double>;
using Entry = Eigen::Triplet<double>;

// Unknowns from which on the dense blocks of supernodal factors save more time than they cost: they
// take a tenth of the time for 260,000. Below, small systems are solved side by side.
constexpr Eigen::Index kSupernodal = 100000;

// Factorisations that know, before the numbers, how many there will be.
class SimplicialFactor : public Eigen::SimplicialLDLT<Sparse, Eigen::Lower> {
 public:
  std::size_t bytes() const {
    constexpr std::size_t kEntry = sizeof(double) + sizeof(StorageIndex);
    return kEntry * static_cast<std::size_t>(m_matrix.data().size());
  }
};
class SupernodalFactor : public Eigen::CholmodSupernodalLLT<Sparse, Eigen::Lower> {
 public:
  SupernodalFactor() { cholmod().print = 0; }
  std::size_t bytes() const { return sizeof(double) * m_cholmodFactor->xsize; }
};

// The solution of a system given by its lower half; no rows where it is singular or `memory` cannot
// be kept.
template <class Factor>
Eigen::MatrixX3d solution(const Sparse& system, const Eigen::MatrixX3d& right,
                          MemoryLimit* memory) {
  Factor factor;
  factor.analyzePattern(system);
  if (!make_room(memory, factor.bytes())) return {};
  factor.factorize(system);
  if (factor.info() != Eigen::Success) return {};
  return factor.solve(right);
}

// Rows of the Laplacian of a patch, split into what multiplies free vertices and what is known.
class PlateSystem {
 public:
  PlateSystem(const TriangleMesh& mesh, const FacesAround& around, const PlatePatch& patch)
      : mesh_(mesh), around_(around) {
    column_.reserve(2 * patch.free.size());
    for (const PlateVertex& free : patch.free)
      column_.emplace(free.vertex, static_cast<int>(column_.size()));
    for (const PlateVertex& support : patch.held) held_.emplace(support.vertex, support.place);
    origin_ = mesh.vertices[patch.free.front().vertex];
    const std::size_t rows = patch.free.size() + patch.held.size();
    known_.setZero(static_cast<Eigen::Index>(rows), 3);
    weights_.resize(static_cast<Eigen::Index>(rows));
    area_.resize(static_cast<Eigen::Index>(rows));
    attraction_.setZero(static_cast<Eigen::Index>(patch.free.size()));
    drawn_.setZero(static_cast<Eigen::Index>(patch.free.size()), 3);
    for (const PlateVertex& free : patch.free) {
      attraction_(row_) = free.attraction * area_at(mesh, around, free.vertex);
      drawn_.row(row_) = attraction_(row_) * (free.place - origin_).transpose();
      add_row(free);
    }
    for (const PlateVertex& support : patch.held) add_row(support);
    laplacian_.resize(static_cast<Eigen::Index>(rows),
                      static_cast<Eigen::Index>(patch.free.size()));
    laplacian_.setFromTriplets(entries_.begin(), entries_.end());
    entries_ = {};
  }

  std::vector<Eigen::Vector3d> solve(MemoryLimit* memory) const {
    const Sparse weighted = weights_.asDiagonal() * laplacian_;
    Sparse system = (laplacian_.transpose() * weighted).triangularView<Eigen::Lower>();
    system.diagonal() += attraction_;
    const Eigen::MatrixX3d right = drawn_ - weighted.transpose() * known_;
    if (system.rows() > kLarge) release_freed_memory();
    return places_of(system.rows() < kSupernodal
                         ? solution<SimplicialFactor>(system, right, memory)
                         : solution<SupernodalFactor>(system, right, memory));
  }

 private:
  std::vector<Eigen::Vector3d> places_of(const Eigen::MatrixX3d& placed) const {
    if (!placed.allFinite()) return {};
    std::vector<Eigen::Vector3d> places;
    for (Eigen::Index i = 0; i < placed.rows(); ++i)
      places.push_back(origin_ + placed.row(i).transpose());
    return places;
  }

  void add(double weight, std::uint32_t vertex) {
    if (const auto free = column_.find(vertex); free != column_.end()) {
      entries_.emplace_back(row_, free->second, weight);
      return;
    }
    const auto held = held_.find(vertex);
    const Eigen::Vector3d& place = held != held_.end() ? held->second : mesh_.vertices[vertex];
    known_.row(row_) += weight * (place - origin_).transpose();
  }

  void add_row(const PlateVertex& vertex) {
    const std::uint32_t v = vertex.vertex;
    double sum = 0.0;
    visit_cotangents(mesh_, around_, v, [&](std::uint32_t other, double weight) {
      add(weight, other);
      sum += weight;
    });
    area_(row_) = area_at(mesh_, around_, v);
    add(vertex.growth * area_(row_) - sum, v);
    weights_(row_) = vertex.stiffness / area_(row_);
    const Eigen::Vector3d here = mesh_.vertices[v] - origin_;
    known_.row(row_) -= area_(row_) * (vertex.rest + vertex.growth * here).transpose();
    ++row_;
  }

  const TriangleMesh& mesh_;
  const FacesAround& around_;
  std::unordered_map<std::uint32_t, int> column_;
  std::unordered_map<std::uint32_t, Eigen::Vector3d> held_;
  Eigen::Vector3d origin_;
  std::vector<Entry> entries_;
  Sparse laplacian_;
  Eigen::MatrixX3d known_;
  Eigen::VectorXd weights_, area_, attraction_;
  Eigen::MatrixX3d drawn_;
  int row_ = 0;
};

}  // namespace

std::vector<Eigen::Vector3d> solve_thin_plate(const TriangleMesh& mesh, const FacesAround& around,
                                              const PlatePatch& patch, MemoryLimit* memory) {
  if (patch.free.empty()) return {};
  if (!make_room(memory, kSystem * patch.free.size())) return {};
  return PlateSystem(mesh, around, patch).solve(memory);
}

}  // namespace relief::fusion
