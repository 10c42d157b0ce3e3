#include "registration/posegraph/loops/view_cycles.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <set>

#include "scan/base/disjoint_sets.h"

namespace relief::registration {

namespace {

using Cycle = std::vector<std::size_t>;

struct LinkedView {
  std::size_t view = 0;
  double overlap = 0.0;
};
using Neighbours = std::vector<std::vector<LinkedView>>;

Neighbours neighbours_of(std::size_t views, const std::vector<ViewPair>& pairs) {
  Neighbours neighbours(views);
  for (const ViewPair& pair : pairs) {
    neighbours[pair.a].push_back({pair.b, pair.overlap});
    neighbours[pair.b].push_back({pair.a, pair.overlap});
  }
  return neighbours;
}

// The pairs that a spanning forest of the largest overlaps leaves out (Kruskal 1956).
std::vector<std::size_t> pairs_outside_forest(std::size_t views,
                                              const std::vector<ViewPair>& pairs) {
  std::vector<std::size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t k) {
    return pairs[i].overlap > pairs[k].overlap;
  });
  DisjointSets trees(views);
  std::vector<std::size_t> outside;
  for (const std::size_t i : order) {
    const auto a = static_cast<std::uint32_t>(pairs[i].a);
    const auto b = static_cast<std::uint32_t>(pairs[i].b);
    if (trees.find(a) == trees.find(b)) outside.push_back(i);
    trees.join(a, b);
  }
  return outside;
}

// Breadth first from one view of a pair to the other, without that pair itself. Within a level the
// way whose least overlap is largest is kept.
class ShortestWay {
 public:
  ShortestWay(const Neighbours& neighbours, const ViewPair& pair)
      : neighbours_(neighbours),
        pair_(pair),
        level_(neighbours.size(), kUnreached),
        width_(neighbours.size(), 0.0),
        from_(neighbours.size(), 0) {
    level_[pair.a] = 0;
    width_[pair.a] = std::numeric_limits<double>::infinity();
    std::vector<std::size_t> front{pair.a};
    for (std::size_t level = 1; !front.empty() && level_[pair.b] == kUnreached; ++level)
      front = next(front, level);
  }

  /// From the pair's first view to its second. The pair is no bridge, so there is one.
  Cycle views() const {
    Cycle way{pair_.b};
    while (way.back() != pair_.a) way.push_back(from_[way.back()]);
    std::reverse(way.begin(), way.end());
    return way;
  }

 private:
  static constexpr std::size_t kUnreached = std::numeric_limits<std::size_t>::max();

  bool is_the_pair(std::size_t v, std::size_t w) const {
    return std::minmax(v, w) == std::minmax(pair_.a, pair_.b);
  }

  std::vector<std::size_t> next(const std::vector<std::size_t>& front, std::size_t level) {
    std::vector<std::size_t> reached;
    for (const std::size_t v : front) {
      for (const LinkedView& to : neighbours_[v]) {
        if (level_[to.view] < level || is_the_pair(v, to.view)) continue;
        const double width = std::min(width_[v], to.overlap);
        if (level_[to.view] == kUnreached) reached.push_back(to.view);
        if (level_[to.view] == level && width <= width_[to.view]) continue;
        level_[to.view] = level;
        width_[to.view] = width;
        from_[to.view] = v;
      }
    }
    return reached;
  }

  const Neighbours& neighbours_;
  const ViewPair& pair_;
  std::vector<std::size_t> level_;  // Pairs from the start.
  std::vector<double> width_;       // The least overlap on the way there.
  std::vector<std::size_t> from_;
};

Cycle from_smallest(Cycle cycle) {
  std::rotate(cycle.begin(), std::min_element(cycle.begin(), cycle.end()), cycle.end());
  if (cycle[1] > cycle.back()) std::reverse(cycle.begin() + 1, cycle.end());
  return cycle;
}

}  // namespace

std::vector<std::vector<std::size_t>> smallest_cycles(std::size_t views,
                                                      const std::vector<ViewPair>& pairs) {
  const Neighbours neighbours = neighbours_of(views, pairs);
  std::set<Cycle> cycles;
  for (const std::size_t i : pairs_outside_forest(views, pairs))
    cycles.insert(from_smallest(ShortestWay(neighbours, pairs[i]).views()));
  return {cycles.begin(), cycles.end()};
}

}  // namespace relief::registration
