#include "scan/grid/small_gaps.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

namespace relief {

namespace {

// Ranges at both ends of a gap differ by noise of this many standard deviations of one range: three
// of a difference, 3 sqrt(2).
constexpr double kNoiseDeviations = 4.25;

struct Interpolated {
  double range = 0.0, weight = 0.0;
};

class Bridging {
 public:
  // Ends of gaps are the samples of the view and those that `known` has bridged.
  Bridging(const RangeView& view, const BridgedRange& known, const SmallGapOptions& options)
      : view_(view), known_(known), options_(options) {}

  bool has(int u, int v) const {
    return known_.range.contains(u, v) && known_.range(u, v) == known_.range(u, v);
  }

  // From the nearest samples on both sides along (du, dv); nothing where they are too far apart or
  // on two surfaces.
  std::optional<Interpolated> across(int u, int v, int du, int dv) const {
    const int after = distance(u, v, du, dv);
    if (after == 0) return std::nullopt;
    const int before = distance(u, v, -du, -dv);
    if (before == 0 || after + before > options_.widest + 1) return std::nullopt;
    const int au = u - before * du, av = v - before * dv, bu = u + after * du, bv = v + after * dv;
    if (!one_surface(au, av, bu, bv)) return std::nullopt;
    const double share = static_cast<double>(before) / (before + after);
    return Interpolated{(1.0 - share) * known_.range(au, av) + share * known_.range(bu, bv),
                        1.0 / (before + after)};
  }

 private:
  // Steps to the first sample, 0 where there is none within reach.
  int distance(int u, int v, int du, int dv) const {
    for (int k = 1; k <= options_.widest; ++k)
      if (has(u + k * du, v + k * dv)) return k;
    return 0;
  }

  bool one_surface(int au, int av, int bu, int bv) const {
    const Ray a = view_.camera.ray(au, av), b = view_.camera.ray(bu, bv);
    const Eigen::Vector3d sight =
        (a.direction.normalized() + b.direction.normalized()).normalized();
    const Eigen::Vector3d edge = b.at(known_.range(bu, bv)) - a.at(known_.range(au, av));
    // Lateral at the nearer end: at the farther one the rays have spread.
    const double near = std::min(known_.range(au, av), known_.range(bu, bv));
    const Eigen::Vector3d across = b.at(near) - a.at(near);
    const double lateral = (across - across.dot(sight) * sight).norm();
    const double noise = kNoiseDeviations * options_.sigma * a.direction.norm();
    return std::abs(edge.dot(sight)) <= options_.steepest * lateral + noise;
  }

  const RangeView& view_;
  const BridgedRange& known_;
  const SmallGapOptions& options_;
};

// Bridges the gaps between the ends that `known` has; along rows or columns, or along both only.
BridgedRange bridge(const RangeView& view, const BridgedRange& known, bool both,
                    const SmallGapOptions& options) {
  BridgedRange result = known;
  const Bridging gaps(view, known, options);
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (gaps.has(u, v)) continue;
      const auto row = gaps.across(u, v, 1, 0);
      if (both && !row) continue;
      const auto column = gaps.across(u, v, 0, 1);
      if (!column && (both || !row)) continue;
      const Interpolated a = row.value_or(Interpolated{}), b = column.value_or(Interpolated{});
      result.range(u, v) = (a.weight * a.range + b.weight * b.range) / (a.weight + b.weight);
      result.bridged(u, v) = 1;
      ++result.bridged_count;
    }
  }
  return result;
}

}  // namespace

BridgedRange bridge_small_gaps(const RangeView& view, const SmallGapOptions& options) {
  assert(options.widest >= 1 && options.steepest > 0.0 && options.sigma >= 0.0);
  const BridgedRange none{view.range, Grid<std::uint8_t>(view.width(), view.height(), 0), 0};
  // Where two gaps cross, samples are missing along the row and the column; what was bridged beside
  // encloses them.
  return bridge(view, bridge(view, none, false, options), true, options);
}

}  // namespace relief
