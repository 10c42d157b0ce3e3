#include "hybrid/model/prepared_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "hybrid/normals/explained_steps.h"
#include "scan/base/median.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/filled_view.h"

namespace relief::hybrid {

namespace {

// What the ranges at one place show of their noise: by the map, and by the change of the
// discrepancy from one edge to the next.
struct Shown {
  float map, change;
};

std::vector<Shown> changes_of(const RangeSteps& steps, const Grid<float>& map) {
  std::vector<Shown> shown;
  const auto collect = [&](const Grid<float>& discrepancy, int du, int dv) {
    for (int v = 0; v + dv < map.height(); ++v) {
      for (int u = 0; u + du < map.width(); ++u) {
        const float change = std::abs(discrepancy(u + du, v + dv) - discrepancy(u, v));
        if (change == change) shown.push_back({map(u, v), change});
      }
    }
  };
  collect(steps.along_rows.discrepancy, 1, 0);
  collect(steps.along_columns.discrepancy, 0, 1);
  return shown;
}

// Whether a sample beside (u, v) lies nearer to the range measured there than to `other`.
bool agrees_with_a_neighbour(const RangeView& measured, int u, int v, double other) {
  const double own = measured.range(u, v);
  for (int y = v - 1; y <= v + 1; ++y) {
    for (int x = u - 1; x <= u + 1; ++x) {
      if ((x == u && y == v) || !measured.has_sample(x, y)) continue;
      const double range = measured.range(x, y);
      if (std::abs(range - own) < std::abs(range - other)) return true;
    }
  }
  return false;
}

void leave_open(int u, int v, FilledView& filled) {
  filled.view.range(u, v) = kNoSample;
  filled.filled(u, v) = 0;
  --filled.filled_count;
}

// Flying samples at an occlusion edge may be the rim of the one surface: the other surface does not
// take their place.
void leave_rims_open(const RangeView& measured, FilledView& filled) {
  for (int v = 0; v < measured.height(); ++v) {
    for (int u = 0; u < measured.width(); ++u) {
      if (!filled.filled(u, v) || !measured.has_sample(u, v)) continue;
      if (agrees_with_a_neighbour(measured, u, v, filled.view.range(u, v)))
        leave_open(u, v, filled);
    }
  }
}

bool beside_occlusion_edge(const RangeView& view, const GridEdges& edges, int u, int v) {
  constexpr std::array<std::array<int, 2>, 4> kSides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  return std::any_of(kSides.begin(), kSides.end(), [&](const auto& side) {
    const auto [du, dv] = side;
    return view.has_sample(u + du, v + dv) && !edges.connected(u, v, du, dv);
  });
}

std::vector<std::array<int, 2>> fills_beside_occlusions(const FilledView& filled,
                                                        const GridEdges& edges) {
  std::vector<std::array<int, 2>> fills;
  for (int v = 0; v < filled.view.height(); ++v) {
    for (int u = 0; u < filled.view.width(); ++u) {
      if (filled.filled(u, v) && beside_occlusion_edge(filled.view, edges, u, v))
        fills.push_back({u, v});
    }
  }
  return fills;
}

// A gap beside an occlusion edge may be of either surface.
void leave_gaps_at_occlusions_open(FilledView& filled, GridEdges& edges) {
  for (const auto& [u, v] : fills_beside_occlusions(filled, edges)) {
    leave_open(u, v, filled);
    edges.right(u, v) = edges.down(u, v) = 0;
    if (u > 0) edges.right(u - 1, v) = 0;
    if (v > 0) edges.down(u, v - 1) = 0;
  }
}

}  // namespace

bool confirms(const RangeSteps& steps, const Grid<float>& map) {
  // Of the logarithm of the map's ratio: midway between noise that does not change (0) and noise
  // that changes as the map says (1).
  constexpr double kShare = 0.5;
  std::vector<Shown> shown = changes_of(steps, map);
  if (shown.size() < 100) return false;
  std::stable_sort(shown.begin(), shown.end(),
                   [](const Shown& a, const Shown& b) { return a.map < b.map; });
  // The quietest quarter against the loudest.
  std::array<std::vector<float>, 2> maps, changes;
  const std::size_t quarter = shown.size() / 4;
  for (std::size_t k = 0; k < quarter; ++k) {
    for (const std::size_t side : {0, 1}) {
      const Shown& one = shown[side == 0 ? k : shown.size() - 1 - k];
      maps[side].push_back(one.map);
      changes[side].push_back(one.change);
    }
  }
  const double by_map = median(maps[1]) / median(maps[0]);
  const double by_steps = median(changes[1]) / median(changes[0]);
  return std::log(by_steps) >= kShare * std::log(by_map);
}

void take_confidence(const Grid<std::uint8_t>& samples, RangeView& view) {
  if (view.confidence.empty()) view.confidence = {view.width(), view.height(), 1.0f};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i]) continue;
    view.confidence[i] = 0.0f;
    if (!view.deviation.empty()) view.deviation[i] = std::numeric_limits<float>::infinity();
  }
}

void count_by_noise(PreparedView& prepared) {
  RangeView& view = prepared.view;
  const auto typical = static_cast<float>(prepared.noise.sigma);
  prepared.variance = prepared.noise.map;
  for (float& value : prepared.variance) value = (value / typical) * (value / typical);
  if (view.confidence.empty()) view.confidence = {view.width(), view.height(), 1.0f};
  for (std::size_t i = 0; i < prepared.variance.size(); ++i)
    view.confidence[i] /= prepared.variance[i];
}

PreparedView prepare_view(const RangeView& view, const DiscontinuityOptions& options) {
  PreparedView prepared;
  prepared.noise = estimate_range_noise(view);
  const auto connect = [&](const RangeView& samples, GridEdges edges) {
    connect_explained_steps(samples, prepared.noise.sigma, edges);
    return edges;
  };
  prepared.edges = connect(view, connect_samples(view, prepared.noise, options));
  FillOptions fill;
  fill.sigma = prepared.noise.sigma;
  FilledView filled = fill_small_gaps(view, prepared.edges, fill);
  leave_rims_open(view, filled);
  prepared.flying = filled.flying;
  prepared.measured_edges = prepared.edges;
  if (filled.flying + filled.filled_count > 0) {
    prepared.edges = connect(filled.view, connect_samples(filled.view, options));
    leave_gaps_at_occlusions_open(filled, prepared.edges);
  }
  prepared.filled = filled.filled_count;
  prepared.view = std::move(filled.view);
  prepared.confidence = prepared.view.confidence;
  prepared.deviation = prepared.view.deviation;
  if (prepared.filled > 0) take_confidence(filled.filled, prepared.view);
  return prepared;
}

}  // namespace relief::hybrid
