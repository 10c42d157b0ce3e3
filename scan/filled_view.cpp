#include "scan/filled_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "scan/range_noise.h"
#include "scan/small_gaps.h"

namespace relief {

namespace {

using Pixel = std::array<int, 2>;
constexpr std::array<Pixel, 4> kNeighbours{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

// The samples connected to (u,v), but at most one more than `most`.
std::vector<Pixel> group_of(int u, int v, const GridEdges& edges, std::size_t most) {
  std::vector<Pixel> group{{u, v}};
  for (std::size_t next = 0; next < group.size() && group.size() <= most; ++next) {
    const auto [pu, pv] = group[next];
    for (const auto& [du, dv] : kNeighbours) {
      const Pixel neighbour{pu + du, pv + dv};
      if (edges.connected(pu, pv, du, dv) &&
          std::find(group.begin(), group.end(), neighbour) == group.end())
        group.push_back(neighbour);
    }
  }
  return group;
}

// Whether most of what is around a group are samples.
bool among_samples(const RangeView& view, const std::vector<Pixel>& group) {
  int samples = 0, around = 0;
  for (const auto& [u, v] : group) {
    for (const auto& [du, dv] : kNeighbours) {
      if (std::find(group.begin(), group.end(), Pixel{u + du, v + dv}) != group.end()) continue;
      ++around;
      samples += view.has_sample(u + du, v + dv) ? 1 : 0;
    }
  }
  return 3 * samples >= 2 * around;
}

// The two samples that a gap lies between along one direction, and how they share in it.
struct GapEnds {
  Pixel a, b;
  double share_of_b;
  double weight;  // The closer together, the more they count.

  double range(const RangeView& view) const {
    return (1.0 - share_of_b) * view.range(a[0], a[1]) + share_of_b * view.range(b[0], b[1]);
  }
};

class Filling {
 public:
  Filling(const RangeView& measured, int widest, RangeView& view)
      : measured_(measured), widest_(widest), view_(view) {}

  // All but the range, which is there already.
  void fill(int u, int v) {
    find_sources(u, v);
    if (view_.has_normals() && !view_.has_normal(u, v)) view_.normals(u, v) = mean_normal();
    if (!view_.confidence.empty())
      view_.confidence(u, v) = mean([&](int x, int y) { return measured_.confidence(x, y); });
    if (!view_.deviation.empty())
      view_.deviation(u, v) = mean([&](int x, int y) { return measured_.deviation(x, y); });
    if (!view_.colours.empty()) view_.colours(u, v) = mean_colour();
  }

 private:
  struct Source {
    int u, v;
    double weight;
  };

  // Of the row and the column, those that the range follows from.
  void find_sources(int u, int v) {
    sources_.clear();
    const GapEnds row = ends(u, v, 1, 0), column = ends(u, v, 0, 1);
    const bool both = row.weight > 0.0 && column.weight > 0.0;
    const auto makes = [&](const GapEnds& one) {
      return one.weight > 0.0 && one.range(measured_) == view_.range(u, v);
    };
    if (!both || !makes(column)) add(row);
    if (!both || !makes(row) || makes(column)) add(column);
  }

  void add(const GapEnds& gap) {
    if (!(gap.weight > 0.0)) return;
    sources_.push_back({gap.a[0], gap.a[1], gap.weight * (1.0 - gap.share_of_b)});
    sources_.push_back({gap.b[0], gap.b[1], gap.weight * gap.share_of_b});
  }

  // Of weight 0 where the gap is too wide.
  GapEnds ends(int u, int v, int du, int dv) const {
    const int after = distance(u, v, du, dv), before = distance(u, v, -du, -dv);
    if (after == 0 || before == 0 || after + before > widest_ + 1) return {{}, {}, 0.0, 0.0};
    const double length = before + after;
    return {{u - before * du, v - before * dv},
            {u + after * du, v + after * dv},
            before / length,
            1.0 / length};
  }

  int distance(int u, int v, int du, int dv) const {
    for (int k = 1; k <= widest_; ++k)
      if (measured_.has_sample(u + k * du, v + k * dv)) return k;
    return 0;
  }

  Eigen::Vector3f mean_normal() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& [u, v, weight] : sources_)
      if (measured_.has_normal(u, v)) sum += weight * measured_.normals(u, v).cast<double>();
    const double length = sum.norm();
    if (!(length > 0.0)) return Eigen::Vector3f::Constant(static_cast<float>(kNoSample));
    return (sum / length).cast<float>();
  }

  // NaN where all values are.
  template <typename Value>
  float mean(const Value& value) const {
    double sum = 0.0, weights = 0.0;
    for (const auto& [u, v, weight] : sources_) {
      const double of_source = value(u, v);
      if (!(of_source == of_source)) continue;
      sum += weight * of_source;
      weights += weight;
    }
    return static_cast<float>(sum / weights);
  }

  Colour mean_colour() const {
    const auto channel = [&](std::size_t k) {
      const float value = mean([&](int u, int v) { return float{measured_.colours(u, v)[k]}; });
      return static_cast<std::uint8_t>(std::lround(value));
    };
    return {channel(0), channel(1), channel(2)};
  }

  const RangeView& measured_;
  int widest_;
  RangeView& view_;
  std::vector<Source> sources_;
};

}  // namespace

Grid<std::uint8_t> flying_samples(const RangeView& view, const GridEdges& edges,
                                  int largest_flying) {
  Grid<std::uint8_t> flying(view.width(), view.height(), 0);
  const auto most = static_cast<std::size_t>(largest_flying);
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const std::vector<Pixel> group = group_of(u, v, edges, most);
      if (group.size() <= most && among_samples(view, group)) flying(u, v) = 1;
    }
  }
  return flying;
}

FilledView fill_small_gaps(const RangeView& view, const GridEdges& edges,
                           const FillOptions& options) {
  FilledView result;
  RangeView measured = view;
  const auto flying = flying_samples(view, edges, options.largest_flying);
  for (std::size_t i = 0; i < flying.size(); ++i) {
    if (!flying[i]) continue;
    measured.range[i] = kNoSample;
    ++result.flying;
  }
  SmallGapOptions gaps;
  gaps.widest = options.widest_gap;
  gaps.sigma =
      options.sigma > 0.0 ? options.sigma : estimate_range_noise(measured, options.threads).sigma;
  BridgedRange bridged = bridge_small_gaps(measured, gaps);
  result.view = measured;
  result.view.range = std::move(bridged.range);
  result.filled = std::move(bridged.bridged);
  result.filled_count = bridged.bridged_count;
  Filling filling(measured, options.widest_gap, result.view);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (result.filled(u, v)) filling.fill(u, v);
  return result;
}

FilledView fill_small_gaps(const RangeView& view, const FillOptions& options) {
  return fill_small_gaps(view, connect_samples(view, {}, options.threads), options);
}

}  // namespace relief
