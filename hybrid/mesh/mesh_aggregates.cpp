#include "hybrid/mesh/mesh_aggregates.h"

#include <algorithm>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
constexpr std::size_t kRowsAtOnce = 16;  // of one piece of work; changes no result

PagedArray<std::uint32_t> aggregate_of_vertices(const Adjacency& graph) {
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
        if (aggregate[other] == kNone && patch.size() < MeshAggregates::kPatch) {
          aggregate[other] = count;
          patch.push_back(other);
        } else if (aggregate[other] < count) {
          beside = aggregate[other];
        }
      }
    }
    if (patch.size() < MeshAggregates::kPatch / 4 && beside != kNone)
      for (const std::uint32_t v : patch) aggregate[v] = beside;
    else
      ++count;
  });
  return aggregate;
}

template <typename Visit>
void for_rows(std::size_t rows, const MeshMatrix& fine, const MeshAggregates& aggregates,
              const Visit& visit) {
  parallel_for(rows, kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
    AggregateRow row;
    for (std::size_t a = begin; a < end; ++a) {
      find_row(fine, aggregates, a, row);
      visit(a, row);
    }
  });
}

}  // namespace

MeshAggregates::MeshAggregates(const Adjacency& graph) : aggregate_(aggregate_of_vertices(graph)) {
  std::size_t count = 0;
  serial_for(aggregate_.size(),
             [&](std::size_t i) { count = std::max<std::size_t>(count, aggregate_[i] + 1); });
  // Until all members are there, the beginning of an aggregate is one place farther.
  first_ = PagedArray<std::size_t>(count + 2);
  serial_for(aggregate_.size(), [&](std::size_t i) { ++first_[aggregate_[i] + 2]; });
  sum_up(first_);
  member_ = PagedArray<std::uint32_t>(aggregate_.size());
  serial_for(aggregate_.size(), [&](std::size_t i) {
    member_[first_[aggregate_[i] + 1]++] = static_cast<std::uint32_t>(i);
  });
}

void find_row(const MeshMatrix& matrix, const MeshAggregates& aggregates, std::size_t aggregate,
              AggregateRow& row) {
  row.diagonal = 0.0;
  row.entries.clear();
  for (const std::uint32_t i : aggregates.members(aggregate)) {
    row.diagonal += matrix.diagonal[i];
    for (std::size_t k = matrix.graph->begin[i]; k < matrix.graph->begin[i + 1]; ++k) {
      const std::uint32_t other = aggregates.of(matrix.graph->neighbour[k]);
      if (other == aggregate)
        row.diagonal += double{matrix.off_diagonal[k]};
      else
        row.entries.push_back({other, double{matrix.off_diagonal[k]}});
    }
  }
  std::stable_sort(row.entries.begin(), row.entries.end(),
                   [](const auto& a, const auto& b) { return a.aggregate < b.aggregate; });
  std::size_t kept = 0;
  for (const AggregateRow::Entry& entry : row.entries) {
    if (kept > 0 && row.entries[kept - 1].aggregate == entry.aggregate)
      row.entries[kept - 1].value += entry.value;
    else
      row.entries[kept++] = entry;
  }
  row.entries.resize(kept);
}

AggregateMatrix::AggregateMatrix(const MeshMatrix& fine, const MeshAggregates& aggregates) {
  const std::size_t rows = aggregates.size();
  graph.begin = PagedArray<std::size_t>(rows + 1);
  for_rows(rows, fine, aggregates, [&](std::size_t a, const AggregateRow& row) {
    graph.begin[a + 1] = row.entries.size();
  });
  sum_up(graph.begin);
  const std::size_t entries = graph.begin[rows];
  graph.neighbour = PagedArray<std::uint32_t>(entries);
  for_rows(rows, fine, aggregates, [&](std::size_t a, const AggregateRow& row) {
    std::size_t k = graph.begin[a];
    for (const AggregateRow::Entry& entry : row.entries) graph.neighbour[k++] = entry.aggregate;
  });
  matrix.graph = &graph;
  matrix.diagonal = MeshValues(rows);
  matrix.off_diagonal = PagedArray<float>(entries);
  update(fine, aggregates);
}

void AggregateMatrix::update(const MeshMatrix& fine, const MeshAggregates& aggregates) {
  for_rows(aggregates.size(), fine, aggregates, [&](std::size_t a, const AggregateRow& row) {
    matrix.diagonal[a] = row.diagonal;
    std::size_t k = graph.begin[a];
    for (const AggregateRow::Entry& entry : row.entries)
      matrix.off_diagonal[k++] = static_cast<float>(entry.value);
  });
}

}  // namespace relief::hybrid
