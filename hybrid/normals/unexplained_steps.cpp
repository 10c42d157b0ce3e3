#include "hybrid/normals/unexplained_steps.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr int kReach = 3;  // samples on either side
// Standard deviations of the difference that is called a step: one of the two million edges of a
// megapixel is cut by chance (6e-7).
constexpr double kDeviations = 5.0;
// Of the median of three Gaussian samples: 1 - sqrt(3) / pi.
constexpr double kMedianVariance = 0.449;

double median_of_first(std::array<double, kReach> values, int count) {
  std::sort(values.begin(), values.begin() + count);
  return 0.5 * (values[static_cast<std::size_t>((count - 1) / 2)] +
                values[static_cast<std::size_t>(count / 2)]);
}

// The edges of one row or column round an edge: discrepancy(k) is that of the k-th edge after it.
struct Line {
  const RangeSteps::Direction& steps;
  int u, v, du, dv;

  double at(const Grid<float>& field, int k) const {
    const int eu = u + k * du, ev = v + k * dv;
    return field.contains(eu, ev) ? field(eu, ev) : kNoSample;
  }
  double discrepancy(int k) const { return at(steps.discrepancy, k); }
};

// Median height of up to three samples on one side, relative to the sample next to the edge.
struct Side {
  double height = 0.0;
  int count = 0;
};

Side side_of(const Line& line, int direction) {
  std::array<double, kReach> heights{};
  Side side{0.0, 1};
  double height = 0.0;
  for (; side.count < kReach; ++side.count) {
    const double step = line.discrepancy(direction * side.count);
    if (!(step == step)) break;
    height += direction * step;
    heights[static_cast<std::size_t>(side.count)] = height;
  }
  side.height = median_of_first(heights, side.count);
  return side;
}

bool is_unexplained(const Line& line, const NoiseEstimate& noise, double range_variance) {
  const double step = line.discrepancy(0);
  if (!(step == step)) return false;
  const Side before = side_of(line, -1), after = side_of(line, 1);
  const double jump = step + after.height - before.height;
  const auto position_part = [](const Side& s) { return s.count < kReach ? 1.0 : kMedianVariance; };
  const double sensitivity = line.at(line.steps.sensitivity, 0);
  const double slopes = 0.5 * (before.count + after.count) * sensitivity;
  const double variance = (position_part(before) + position_part(after)) * range_variance +
                          slopes * sensitivity * noise.sigma_normal * noise.sigma_normal +
                          slopes * slopes * noise.bias * noise.bias;
  if (jump * jump <= kDeviations * kDeviations * variance) return false;
  // The cut is where the step is, not beside it.
  const auto not_larger = [&](int k) { return !(std::abs(line.discrepancy(k)) > std::abs(step)); };
  return step * jump > 0.5 * jump * jump && not_larger(-1) && not_larger(1);
}

void cut(const RangeSteps::Direction& steps, int du, int dv, const NoiseEstimate& noise,
         const Grid<float>& variance, Grid<std::uint8_t>& connected) {
  const auto variance_at = [&](int u, int v) {
    const double factor = variance.empty() ? 1.0 : double{variance(u, v)};
    return factor * noise.sigma_local * noise.sigma_local;
  };
  const auto cut_row = [&](int v) {
    for (int u = 0; u < connected.width(); ++u)
      if (connected(u, v) && is_unexplained({steps, u, v, du, dv}, noise, variance_at(u, v)))
        connected(u, v) = 0;
  };
  parallel_for(static_cast<std::size_t>(connected.height()), 16,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t v = begin; v < end; ++v) cut_row(static_cast<int>(v));
               });
}

}  // namespace

GridEdges cut_unexplained_steps(const GridEdges& edges, const RangeSteps& steps,
                                const NoiseEstimate& noise, const Grid<float>& variance) {
  GridEdges remaining = edges;
  cut(steps.along_rows, 1, 0, noise, variance, remaining.right);
  cut(steps.along_columns, 0, 1, noise, variance, remaining.down);
  return remaining;
}

}  // namespace relief::hybrid
