#include "hybrid/multigrid/aggregation.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <utility>

#include "scan/base/disjoint_sets.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

using Bond = Aggregates::Bond;
using Node = Aggregates::Node;

constexpr int kBlock = 3;  // places of a block along each direction
constexpr int kPlaces = kBlock * kBlock;
constexpr std::size_t kRowsAtOnce = 8;  // of blocks, of one piece of work; changes no result

// A bond far weaker than others at both its ends joins nothing: what it connects moves apart.
// With a fiftieth the solver takes 3 to 40 steps where 10 % of the samples are missing and weights
// differ by up to 10^4 (docs/results.md, Steps of the solver).
constexpr float kWeak = 0.02f;

bool is_strong(float strength, float largest_at_a, float largest_at_b) {
  return strength > 0.0f && strength >= kWeak * std::min(largest_at_a, largest_at_b);
}

// The bond of the constraint at pixel i along an axis.
float strength_of(const StencilView::Axis& axis, std::size_t i) {
  return axis.weight[i] * axis.tail[i] * axis.head[i];
}

// From the tail of a constraint to its head.
Transport across(const StencilView::Axis& axis, int direction, std::size_t i) {
  const float head = axis.head[i], slide = 2.0f * axis.half_length[i] / head;
  return {axis.tail[i] / head, direction == 0 ? slide : 0.0f, direction == 1 ? slide : 0.0f};
}

// The bond between groups that a bond between members a and b makes; members move from their roots
// as given. Needs different groups.
Bond lifted(const Bond& bond, std::uint32_t group_a, std::uint32_t group_b,
            const Transport& a_from_root, const Transport& b_from_root) {
  const Transport b_from_a = a_from_root.then(bond.b_from_a).then(b_from_root.inverse());
  if (group_a < group_b) return {group_a, group_b, bond.strength, b_from_a};
  return {group_b, group_a, bond.strength, b_from_a.inverse()};
}

void merge_into(Bond& sum, const Bond& other) {
  const float total = sum.strength + other.strength, share = other.strength / total;
  const auto blend = [&](float& value, float next) { value += share * (next - value); };
  blend(sum.b_from_a.scale, other.b_from_a.scale);
  blend(sum.b_from_a.along_u, other.b_from_a.along_u);
  blend(sum.b_from_a.along_v, other.b_from_a.along_v);
  sum.strength = total;
}

// Orders bonds and merges those between the same nodes.
void unify(std::vector<Bond>& bonds) {
  std::stable_sort(bonds.begin(), bonds.end(), [](const Bond& x, const Bond& y) {
    return std::tie(x.a, x.b) < std::tie(y.a, y.b);
  });
  std::size_t last = 0;
  for (std::size_t k = 1; k < bonds.size(); ++k) {
    if (bonds[k].a == bonds[last].a && bonds[k].b == bonds[last].b)
      merge_into(bonds[last], bonds[k]);
    else
      bonds[++last] = bonds[k];
  }
  if (!bonds.empty()) bonds.resize(last + 1);
}

// Groups the pixels of rows of blocks; labels count from zero in each row of blocks.
class PixelGrouping {
 public:
  PixelGrouping(const EdgeStencil& stencil, Aggregates& aggregates)
      : grid_(stencil.grid()), view_(stencil.view()), out_(aggregates) {}

  std::vector<Node> group_row(int row) {
    std::vector<Node> nodes;
    for (int column = 0; column * kBlock < grid_.width; ++column) {
      find_members(column, row);
      find_bonds();
      for (const int place : {4, 1, 3, 5, 7, 0, 2, 6, 8}) {  // roots near the middle
        if (!is_member_[place] || out_.label[index_[place]] != kNoAggregate) continue;
        spread_from(place, static_cast<std::uint32_t>(nodes.size()));
        nodes.push_back({column, row});
      }
    }
    return nodes;
  }

  // Bonds between groups of one row of blocks and to the next.
  std::vector<Bond> bonds_of_row(int row) const {
    std::vector<Bond> bonds;
    for (int v = row * kBlock; v < std::min(grid_.height, (row + 1) * kBlock); ++v) {
      for (const int axis : {1, 0}) {
        for (std::size_t i = grid_.index(0, v); i < grid_.index(grid_.width, v); ++i) {
          const auto j = i + static_cast<std::size_t>(grid_.step(axis));
          const float strength = strength_of(along(axis), i);
          if (strength <= 0.0f || out_.label[i] == out_.label[j]) continue;
          const Bond between{0, 0, strength, across(along(axis), axis, i)};
          const Bond bond =
              lifted(between, out_.label[i], out_.label[j], out_.from_root[i], out_.from_root[j]);
          if (!bonds.empty() && bonds.back().a == bond.a && bonds.back().b == bond.b)
            merge_into(bonds.back(), bond);
          else
            bonds.push_back(bond);
        }
      }
    }
    unify(bonds);
    return bonds;
  }

 private:
  const StencilView::Axis& along(int axis) const {
    return axis == 0 ? view_.along_u : view_.along_v;
  }

  void find_members(int column, int row) {
    const auto stride = static_cast<std::size_t>(grid_.stride());
    columns_ = std::min(kBlock, grid_.width - column * kBlock);
    rows_ = std::min(kBlock, grid_.height - row * kBlock);
    is_member_.fill(false);
    for (int place = 0; place < kPlaces; ++place) {
      if (place % kBlock >= columns_ || place / kBlock >= rows_) continue;
      const std::size_t i = index_[place] =
          grid_.index(column * kBlock + place % kBlock, row * kBlock + place / kBlock);
      largest_[place] =
          std::max(std::max(strength_of(view_.along_u, i - 1),  //
                            strength_of(view_.along_u, i)),
                   std::max(strength_of(view_.along_v, i - stride), strength_of(view_.along_v, i)));
      is_member_[place] = largest_[place] > 0.0f;
    }
  }

  void find_bonds() {
    for (int place = 0; place < kPlaces; ++place) {
      for (const int axis : {0, 1}) {
        const int next = place + (axis == 0 ? 1 : kBlock);
        const bool inside = axis == 0 ? place % kBlock + 1 < columns_ : place / kBlock + 1 < rows_;
        strong_[axis][place] =
            inside && is_member_[place] && is_member_[next] &&
            is_strong(strength_of(along(axis), index_[place]), largest_[place], largest_[next]);
      }
    }
  }

  // Gives a group all that hangs on one of its pixels, nearest first.
  void spread_from(int root, std::uint32_t group) {
    std::array<int, kPlaces> queue{root};
    int end = 1;
    out_.label[index_[root]] = group;
    out_.from_root[index_[root]] = {};
    const auto visit = [&](int from, int to, const Transport& step) {
      if (out_.label[index_[to]] != kNoAggregate) return;
      out_.label[index_[to]] = group;
      out_.from_root[index_[to]] = out_.from_root[index_[from]].then(step);
      queue[end++] = to;
    };
    for (int begin = 0; begin < end; ++begin) {
      const int p = queue[begin];
      for (const int axis : {0, 1}) {
        const int step = axis == 0 ? 1 : kBlock;
        if (strong_[axis][p]) visit(p, p + step, across(along(axis), axis, index_[p]));
        if (p >= step && strong_[axis][p - step])
          visit(p, p - step, across(along(axis), axis, index_[p - step]).inverse());
      }
    }
  }

  const PaddedGrid& grid_;
  StencilView view_;
  Aggregates& out_;
  // The block at work: places are 0 to 8, row by row.
  int columns_ = 0, rows_ = 0;
  std::array<std::size_t, kPlaces> index_{};
  std::array<float, kPlaces> largest_{};
  std::array<bool, kPlaces> is_member_{};
  std::array<std::array<bool, kPlaces>, 2> strong_{};
};

// Labels that count from zero in each row of blocks become labels of the whole.
void count_on(const EdgeStencil& stencil, const std::vector<std::vector<Node>>& of_row,
              Aggregates& aggregates) {
  aggregates.rows = {0};
  for (const auto& nodes : of_row) {
    aggregates.nodes.insert(aggregates.nodes.end(), nodes.begin(), nodes.end());
    aggregates.rows.push_back(static_cast<std::uint32_t>(aggregates.nodes.size()));
  }
  parallel_for(stencil.spans().size(), kBlock * kRowsAtOnce,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t v = begin; v < end; ++v) {
                   const RowSpan span = stencil.spans()[v];
                   for (std::size_t i = span.begin; i < span.end; ++i)
                     if (aggregates.label[i] != kNoAggregate)
                       aggregates.label[i] += aggregates.rows[v / kBlock];
                 }
               });
}

std::pair<int, int> block_of(const Node& node) { return {node.row / kBlock, node.column / kBlock}; }

// The bonds that make groups.
std::vector<Bond> strong_bonds_in_blocks(const Aggregates& below,
                                         const std::vector<float>& largest) {
  std::vector<Bond> inside;
  for (const Bond& bond : below.bonds)
    if (block_of(below.nodes[bond.a]) == block_of(below.nodes[bond.b]) &&
        is_strong(bond.strength, largest[bond.a], largest[bond.b]))
      inside.push_back(bond);
  return inside;
}

// From the roots outwards, nearest first.
std::vector<Transport> transports(const std::vector<std::uint32_t>& root, std::vector<Bond> bonds) {
  std::vector<Transport> from_root(root.size());
  std::vector<int> distance(root.size(), -1);
  for (std::uint32_t i = 0; i < root.size(); ++i)
    if (root[i] == i) distance[i] = 0;
  const auto reach = [&](std::uint32_t from, std::uint32_t to, const Transport& step, int ring) {
    if (distance[from] != ring || distance[to] >= 0) return;
    from_root[to] = from_root[from].then(step);
    distance[to] = ring + 1;
  };
  for (int ring = 0; !bonds.empty(); ++ring) {
    for (const Bond& bond : bonds) {
      reach(bond.a, bond.b, bond.b_from_a, ring);
      reach(bond.b, bond.a, bond.b_from_a.inverse(), ring);
    }
    std::erase_if(bonds, [&](const Bond& b) { return distance[b.a] >= 0 && distance[b.b] >= 0; });
  }
  return from_root;
}

// Numbers the groups by the blocks of their roots.
void number_groups(const Aggregates& below, const std::vector<std::uint32_t>& root,
                   const std::vector<float>& largest, Aggregates& aggregates) {
  std::vector<std::uint32_t> roots;
  for (std::uint32_t i = 0; i < root.size(); ++i)
    if (root[i] == i && largest[i] > 0.0f) roots.push_back(i);
  std::sort(roots.begin(), roots.end(), [&](std::uint32_t x, std::uint32_t y) {
    return std::tuple(block_of(below.nodes[x]), x) < std::tuple(block_of(below.nodes[y]), y);
  });
  aggregates.label.assign(root.size(), kNoAggregate);
  aggregates.rows.assign((below.rows.size() - 1 + kBlock - 1) / kBlock + 1, 0);
  for (const std::uint32_t i : roots) {
    aggregates.label[i] = static_cast<std::uint32_t>(aggregates.nodes.size());
    const auto [row, column] = block_of(below.nodes[i]);
    aggregates.nodes.push_back({column, row});
    ++aggregates.rows[static_cast<std::size_t>(row) + 1];
  }
  std::partial_sum(aggregates.rows.begin(), aggregates.rows.end(), aggregates.rows.begin());
  for (std::uint32_t i = 0; i < root.size(); ++i) aggregates.label[i] = aggregates.label[root[i]];
}

}  // namespace

Aggregates aggregate_pixels(const EdgeStencil& stencil) {
  Aggregates aggregates;
  aggregates.label.assign(stencil.grid().size(), kNoAggregate);
  aggregates.from_root.resize(stencil.grid().size());
  const auto rows = static_cast<std::size_t>((stencil.grid().height + kBlock - 1) / kBlock);
  std::vector<std::vector<Node>> nodes(rows);
  std::vector<std::vector<Bond>> bonds(rows);
  const auto each_row = [&](const auto& body) {
    parallel_for(rows, kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
      PixelGrouping grouping(stencil, aggregates);
      for (std::size_t row = begin; row < end; ++row) body(grouping, row);
    });
  };
  each_row([&](auto& grouping, auto row) { nodes[row] = grouping.group_row(int(row)); });
  count_on(stencil, nodes, aggregates);
  each_row([&](auto& grouping, auto row) { bonds[row] = grouping.bonds_of_row(int(row)); });
  for (std::vector<Bond>& of_row : bonds) {
    aggregates.bonds.insert(aggregates.bonds.end(), of_row.begin(), of_row.end());
    of_row = {};
  }
  return aggregates;
}

Aggregates aggregate_nodes(const Aggregates& below) {
  std::vector<float> largest(below.nodes.size(), 0.0f);
  for (const Bond& bond : below.bonds)
    for (const std::uint32_t i : {bond.a, bond.b}) largest[i] = std::max(largest[i], bond.strength);
  std::vector<Bond> inside = strong_bonds_in_blocks(below, largest);
  DisjointSets sets(below.nodes.size());
  for (const Bond& bond : inside) sets.join(bond.a, bond.b);
  std::vector<std::uint32_t> root(below.nodes.size());
  for (std::uint32_t i = 0; i < root.size(); ++i) root[i] = sets.find(i);

  Aggregates aggregates;
  number_groups(below, root, largest, aggregates);
  aggregates.from_root = transports(root, std::move(inside));
  for (const Bond& bond : below.bonds) {
    const std::uint32_t a = aggregates.label[bond.a], b = aggregates.label[bond.b];
    if (a != b)
      aggregates.bonds.push_back(
          lifted(bond, a, b, aggregates.from_root[bond.a], aggregates.from_root[bond.b]));
  }
  unify(aggregates.bonds);
  return aggregates;
}

}  // namespace relief::hybrid
