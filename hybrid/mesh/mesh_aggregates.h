#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hybrid/mesh/mesh_graph.h"
#include "hybrid/mesh/mesh_solver.h"
#include "scan/base/memory/paged_array.h"

namespace relief::hybrid {

/// Disjoint groups of some dozens of vertices that hang together: breadth-first patches in the
/// order of their first vertices. What is cut off between patches joins a neighbour's.
class MeshAggregates {
 public:
  /// Vertices of a patch at most. It makes the preconditioner: it changes the number of steps, not
  /// what is minimised.
  static constexpr std::size_t kPatch = 48;

  explicit MeshAggregates(const Adjacency& graph);

  std::size_t size() const { return first_.size() - 2; }
  std::uint32_t of(std::size_t vertex) const { return aggregate_[vertex]; }
  /// Ascending.
  std::span<const std::uint32_t> members(std::size_t aggregate) const {
    return member_.span().subspan(first_[aggregate], first_[aggregate + 1] - first_[aggregate]);
  }

 private:
  PagedArray<std::uint32_t> aggregate_;  // of each vertex
  // The vertices of aggregate a: member_[first_[a]] to member_[first_[a + 1]].
  PagedArray<std::size_t> first_;
  PagedArray<std::uint32_t> member_;
};

/// One row of P^T A P, where P gives all vertices of an aggregate the same value.
struct AggregateRow {
  struct Entry {
    std::uint32_t aggregate;
    double value;
  };
  double diagonal = 0.0;
  std::vector<Entry> entries;  ///< Off the diagonal, by rising aggregate.
};
/// Into `row`, whose memory is used again.
void find_row(const MeshMatrix& matrix, const MeshAggregates& aggregates, std::size_t aggregate,
              AggregateRow& row);

/// P^T A P. Memory: paged arrays.
struct AggregateMatrix {
  AggregateMatrix(const MeshMatrix& fine, const MeshAggregates& aggregates);
  AggregateMatrix(const AggregateMatrix&) = delete;
  AggregateMatrix& operator=(const AggregateMatrix&) = delete;
  /// Takes up new values of a matrix with the same graph.
  void update(const MeshMatrix& fine, const MeshAggregates& aggregates);

  Adjacency graph;
  MeshMatrix matrix;
};

}  // namespace relief::hybrid
