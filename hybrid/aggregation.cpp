#include "hybrid/aggregation.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

#include "scan/parallel.h"

namespace relief {

namespace {

constexpr int kBlock = 3;  // places of a block along each direction

// A bond far weaker than others at both its ends joins nothing: what it connects moves apart.
constexpr float kWeak = 0.02f;

bool is_strong(float strength, float largest_at_a, float largest_at_b) {
  return strength > 0.0f && strength >= kWeak * std::min(largest_at_a, largest_at_b);
}

float conductance(const EdgeStencil::Axis& axis, std::size_t i) {
  return axis.weight[i] * axis.tail[i] * axis.head[i];
}

// The mean displacement per pixel and slope along one axis.
struct Metric {
  float sum = 0.0f;
  int count = 0;
  void add(float value) {
    if (value == 0.0f) return;
    sum += value;
    ++count;
  }
  float mean() const { return count > 0 ? sum / static_cast<float>(count) : 0.0f; }
};

void order_bonds(std::vector<Aggregates::Bond>& bonds) {
  std::sort(bonds.begin(), bonds.end(), [](const auto& x, const auto& y) {
    return std::tie(x.a, x.b, x.strength) < std::tie(y.a, y.b, y.strength);
  });
  std::size_t last = 0;
  for (std::size_t k = 1; k < bonds.size(); ++k) {
    if (bonds[k].a == bonds[last].a && bonds[k].b == bonds[last].b)
      bonds[last].strength += bonds[k].strength;
    else
      bonds[++last] = bonds[k];
  }
  if (!bonds.empty()) bonds.resize(last + 1);
}

// Groups the pixels of one row of blocks; labels count from zero in each row of blocks.
class PixelBlockRow {
 public:
  PixelBlockRow(const EdgeStencil& stencil, int row)
      : stencil_(stencil), stride_(static_cast<std::size_t>(stencil.grid.stride())), row_(row) {}

  std::vector<Aggregates::Node> group(std::vector<std::uint32_t>& label) {
    std::vector<Aggregates::Node> nodes;
    const PaddedGrid& grid = stencil_.grid;
    for (int column = 0; column * kBlock < grid.width; ++column) group_block(column, label, nodes);
    return nodes;
  }

 private:
  bool moves(std::size_t i) const {
    const auto stencil_weight = [&](const EdgeStencil::Axis& axis, std::size_t k) {
      return axis.weight[k] > 0.0f;
    };
    return stencil_weight(stencil_.along_u, i) || stencil_weight(stencil_.along_u, i - 1) ||
           stencil_weight(stencil_.along_v, i) || stencil_weight(stencil_.along_v, i - stride_);
  }

  float largest_at(std::size_t i) const {
    return std::max(
        std::max(conductance(stencil_.along_u, i), conductance(stencil_.along_u, i - 1)),
        std::max(conductance(stencil_.along_v, i), conductance(stencil_.along_v, i - stride_)));
  }

  // Places of a block are 0 to 8, row by row; a group is known by its smallest place.
  void group_block(int column, std::vector<std::uint32_t>& label,
                   std::vector<Aggregates::Node>& nodes) {
    const PaddedGrid& grid = stencil_.grid;
    const int u0 = column * kBlock, v0 = row_ * kBlock;
    const int columns = std::min(kBlock, grid.width - u0),
              rows = std::min(kBlock, grid.height - v0);
    std::array<int, kBlock * kBlock> group{};
    std::array<float, kBlock * kBlock> largest{};
    std::array<std::uint32_t, kBlock * kBlock> index{};
    for (int v = 0; v < rows; ++v) {
      for (int u = 0; u < columns; ++u) {
        const int place = v * kBlock + u;
        const std::uint32_t i = index[place] = grid.index(u0 + u, v0 + v);
        group[place] = moves(i) ? place : -1;
        if (group[place] >= 0) largest[place] = largest_at(i);
      }
    }
    const auto join = [&](int a, int b, float strength) {
      if (group[a] < 0 || group[b] < 0 || group[a] == group[b]) return;
      if (!is_strong(strength, largest[a], largest[b])) return;
      const int from = std::max(group[a], group[b]), to = std::min(group[a], group[b]);
      std::replace(group.begin(), group.end(), from, to);
    };
    for (int v = 0; v < rows; ++v) {
      for (int u = 0; u < columns; ++u) {
        const int place = v * kBlock + u;
        if (group[place] < 0) continue;
        if (u + 1 < columns) join(place, place + 1, conductance(stencil_.along_u, index[place]));
        if (v + 1 < rows) join(place, place + kBlock, conductance(stencil_.along_v, index[place]));
      }
    }
    for (int place = 0; place < kBlock * kBlock; ++place)
      if (group[place] == place && index[place] != 0)
        add_node(column, place, group, index, label, nodes);
  }

  void add_node(int column, int which, const std::array<int, kBlock * kBlock>& group,
                const std::array<std::uint32_t, kBlock * kBlock>& index,
                std::vector<std::uint32_t>& label, std::vector<Aggregates::Node>& nodes) {
    Aggregates::Node node{.column = column, .row = row_};
    Metric metric_u, metric_v;
    float members = 0.0f;
    for (int place = which; place < kBlock * kBlock; ++place) {
      if (group[place] != which || index[place] == 0) continue;
      const std::size_t i = index[place];
      label[i] = static_cast<std::uint32_t>(nodes.size());
      node.u += static_cast<float>(column * kBlock + place % kBlock);
      node.v += static_cast<float>(row_ * kBlock + place / kBlock);
      members += 1.0f;
      for (const std::size_t k : {i, i - 1}) metric_u.add(metric(stencil_.along_u, k));
      for (const std::size_t k : {i, i - stride_}) metric_v.add(metric(stencil_.along_v, k));
    }
    node.u /= members;
    node.v /= members;
    node.metric_u = metric_u.mean();
    node.metric_v = metric_v.mean();
    nodes.push_back(node);
  }

  // x_head - x_tail that satisfies a constraint along a slope of one.
  static float metric(const EdgeStencil::Axis& axis, std::size_t i) {
    const float slope = axis.tail[i] + axis.head[i];
    return axis.half_length[i] > 0.0f ? 4.0f * axis.half_length[i] / slope : 0.0f;
  }

  const EdgeStencil& stencil_;
  std::size_t stride_;
  int row_;
};

std::vector<Aggregates::Bond> bonds_between(const EdgeStencil& stencil,
                                            const std::vector<std::uint32_t>& label) {
  std::vector<Aggregates::Bond> bonds;
  const auto stride = static_cast<std::size_t>(stencil.grid.stride());
  const auto add = [&](std::size_t i, std::size_t j, float strength) {
    if (strength <= 0.0f || label[i] == label[j]) return;
    const auto [a, b] = std::minmax(label[i], label[j]);
    if (!bonds.empty() && bonds.back().a == a && bonds.back().b == b)
      bonds.back().strength += strength;
    else
      bonds.push_back({a, b, strength});
  };
  // Along columns first in one sweep of each row: equal bonds follow one another.
  for (const EdgeStencil::Span& span : stencil.spans) {
    for (std::size_t i = span.begin; i < span.end; ++i)
      add(i, i + stride, conductance(stencil.along_v, i));
    for (std::size_t i = span.begin; i < span.end; ++i)
      add(i, i + 1, conductance(stencil.along_u, i));
  }
  order_bonds(bonds);
  return bonds;
}

}  // namespace

Aggregates aggregate_pixels(const EdgeStencil& stencil, int threads) {
  Aggregates aggregates;
  aggregates.label.assign(stencil.grid.size(), kNoAggregate);
  const auto rows = static_cast<std::size_t>((stencil.grid.height + kBlock - 1) / kBlock);
  std::vector<std::vector<Aggregates::Node>> of_row(rows);
  parallel_for(rows, 8, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      of_row[row] = PixelBlockRow(stencil, static_cast<int>(row)).group(aggregates.label);
  });
  aggregates.rows = {0};
  for (std::size_t row = 0; row < rows; ++row) {
    const std::uint32_t first = aggregates.rows.back();
    aggregates.nodes.insert(aggregates.nodes.end(), of_row[row].begin(), of_row[row].end());
    aggregates.rows.push_back(static_cast<std::uint32_t>(aggregates.nodes.size()));
    const int last_v = std::min(stencil.grid.height, static_cast<int>(row + 1) * kBlock);
    for (int v = static_cast<int>(row) * kBlock; v < last_v; ++v) {
      const EdgeStencil::Span span = stencil.spans[static_cast<std::size_t>(v)];
      for (std::size_t i = span.begin; i < span.end; ++i)
        if (aggregates.label[i] != kNoAggregate) aggregates.label[i] += first;
    }
  }
  aggregates.bonds = bonds_between(stencil, aggregates.label);
  return aggregates;
}

Aggregates aggregate_nodes(const Aggregates& below) {
  const std::size_t count = below.nodes.size();
  std::vector<float> largest(count, 0.0f);
  for (const auto& bond : below.bonds)
    for (const std::uint32_t i : {bond.a, bond.b}) largest[i] = std::max(largest[i], bond.strength);
  // Groups within blocks: every node points to a smaller one of its group, or to itself.
  std::vector<std::uint32_t> parent(count);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto block_of = [&](std::uint32_t i) {
    return std::pair{below.nodes[i].row / kBlock, below.nodes[i].column / kBlock};
  };
  for (const auto& bond : below.bonds) {
    if (block_of(bond.a) != block_of(bond.b)) continue;
    if (!is_strong(bond.strength, largest[bond.a], largest[bond.b])) continue;
    const std::uint32_t a = root(bond.a), b = root(bond.b);
    parent[std::max(a, b)] = std::min(a, b);
  }
  std::vector<std::uint32_t> roots;
  for (std::uint32_t i = 0; i < count; ++i)
    if (root(i) == i && largest[i] > 0.0f) roots.push_back(i);
  std::sort(roots.begin(), roots.end(), [&](std::uint32_t x, std::uint32_t y) {
    return std::tuple(block_of(x), x) < std::tuple(block_of(y), y);
  });

  Aggregates aggregates;
  aggregates.label.assign(count, kNoAggregate);
  const auto rows = (below.rows.size() - 1 + kBlock - 1) / kBlock;
  aggregates.rows.assign(rows + 1, 0);
  for (const std::uint32_t i : roots) {
    aggregates.label[i] = static_cast<std::uint32_t>(aggregates.nodes.size());
    const auto [row, column] = block_of(i);
    aggregates.nodes.push_back({.column = column, .row = row});
    ++aggregates.rows[static_cast<std::size_t>(row) + 1];
  }
  std::partial_sum(aggregates.rows.begin(), aggregates.rows.end(), aggregates.rows.begin());
  std::vector<Metric> metric_u(aggregates.nodes.size()), metric_v(aggregates.nodes.size());
  std::vector<float> members(aggregates.nodes.size(), 0.0f);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t k = aggregates.label[i] = aggregates.label[root(i)];
    if (k == kNoAggregate) continue;
    members[k] += 1.0f;
    aggregates.nodes[k].u += below.nodes[i].u;
    aggregates.nodes[k].v += below.nodes[i].v;
    metric_u[k].add(below.nodes[i].metric_u);
    metric_v[k].add(below.nodes[i].metric_v);
  }
  for (std::size_t k = 0; k < aggregates.nodes.size(); ++k) {
    Aggregates::Node& node = aggregates.nodes[k];
    node.u /= members[k];
    node.v /= members[k];
    node.metric_u = metric_u[k].mean();
    node.metric_v = metric_v[k].mean();
  }
  for (const auto& bond : below.bonds) {
    const auto [a, b] = std::minmax(aggregates.label[bond.a], aggregates.label[bond.b]);
    if (a != b) aggregates.bonds.push_back({a, b, bond.strength});
  }
  order_bonds(aggregates.bonds);
  return aggregates;
}

}  // namespace relief
