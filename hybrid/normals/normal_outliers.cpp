#include "hybrid/normals/normal_outliers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "hybrid/model/rectangle_sums.h"
#include "relief/scan/grid.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

// Standard deviations that noise does not reach: 2e-9 of a Gaussian lies beyond.
constexpr double kDeviations = 6.0;
// That the mean slope of a window is good to [rad]. At 0.3 spacings and 1.5 degrees windows have 7
// samples and find errors of 11 degrees; at half of it 11 and 5, at twice 5 and 19.
constexpr double kPrecision = 0.03;
constexpr int kSmallest = 2, kLargest = 6;  // half widths of windows [samples]
// Distance of the windows round about [half-windows]: clear of patches up to ten of these across.
constexpr int kRing = 6;
constexpr std::size_t kFewest = 5;  // of the eight windows round about: more than half
// Confidence of ranges that may contradict normals: theirs is at most twice the typical deviation,
// so that six deviations are still three.
constexpr float kTrusted = 0.25f;

// Variance of the mean slope of rows of 2 x `half` constraints, `constraints` in all: in a row, all
// but the first and the last range cancel.
double mean_variance(double constraints, int half, const NoiseEstimate& noise, double spacing) {
  const double position = noise.sigma_position / spacing;
  return (position * position / half + noise.sigma_normal * noise.sigma_normal) / constraints;
}

int window_for(const NoiseEstimate& noise, double spacing) {
  int half = kSmallest;
  while (half < kLargest &&
         mean_variance(2.0 * half * (2 * half + 1), half, noise, spacing) > kPrecision * kPrecision)
    ++half;
  return half;
}

// 1 for the constraints along an axis between samples whose ranges can be trusted.
std::vector<std::uint8_t> trusted_constraints(const ViewProblem& problem, std::size_t axis) {
  std::vector<std::uint8_t> sample(problem.grid.size(), 0), result(problem.grid.size(), 0);
  for (std::size_t k = 0; k < problem.size(); ++k)
    sample[problem.pixels[k]] = problem.confidence[static_cast<Eigen::Index>(k)] >= kTrusted;
  const auto step = static_cast<std::size_t>(problem.grid.step(static_cast<int>(axis)));
  for (const std::uint32_t i : problem.pixels)
    result[i] = problem.slopes.exists(static_cast<int>(axis), i) && sample[i] && sample[i + step];
  return result;
}

// Mean slopes of the ranges against the normals along one axis; NaN where the window is not nearly
// full.
Grid<double> window_slopes(const ViewProblem& problem, std::size_t axis, int half) {
  const PaddedGrid& grid = problem.grid;
  const SlopeConstraints::Axis& a = problem.slopes.axes[axis];
  const std::vector<std::uint8_t> use = trusted_constraints(problem, axis);
  const RectangleSums steps(grid, [&](std::size_t i) { return use[i] * double{a.step[i]}; });
  const double enough = 0.75 * 2 * half * (2 * half + 1);
  const RectangleSums lengths(
      grid, [&](std::size_t i) { return use[i] * 2.0 * double{a.half_length[i]}; });
  const RectangleSums counts(grid, [&](std::size_t i) { return use[i]; });
  Grid<double> result(grid.width, grid.height, kNoSample);
  parallel_rows(grid.height, [&](int v) {
    for (int u = 0; u < grid.width; ++u) {
      // A constraint belongs to the pixel before it.
      const int u1 = u + half + (axis == 1), v1 = v + half + (axis == 0);
      if (counts(u - half, u1, v - half, v1) < enough) continue;
      result(u, v) = steps(u - half, u1, v - half, v1) / lengths(u - half, u1, v - half, v1);
    }
  });
  return result;
}

// The windows round about one, those that there are.
struct Ring {
  std::array<double, 8> slopes;
  std::size_t size = 0;

  Ring(const Grid<double>& all, int u, int v, int distance) {
    for (const int dv : {-distance, 0, distance})
      for (const int du : {-distance, 0, distance})
        if ((du != 0 || dv != 0) && all.contains(u + du, v + dv) &&
            std::isfinite(all(u + du, v + dv)))
          slopes[size++] = all(u + du, v + dv);
  }

  // Most of them, and so their median, are within `limit` of `slope`.
  bool surely_within(double slope, double limit) const {
    std::size_t close = 0;
    for (std::size_t k = 0; k < size; ++k) close += std::abs(slopes[k] - slope) <= limit ? 1 : 0;
    return 2 * close > size + 1;
  }
  double median() {
    const auto middle = slopes.begin() + static_cast<std::ptrdiff_t>(size / 2);
    std::nth_element(slopes.begin(), middle, slopes.begin() + static_cast<std::ptrdiff_t>(size));
    return *middle;
  }
};

// What windows differ by from those round about; zero where that is within `least`.
Grid<double> contradictions(const Grid<double>& slopes, int half, double least) {
  Grid<double> result(slopes.width(), slopes.height(), 0.0);
  parallel_rows(slopes.height(), [&](int v) {
    for (int u = 0; u < slopes.width(); ++u) {
      if (!(slopes(u, v) == slopes(u, v))) continue;
      Ring ring(slopes, u, v, kRing * half);
      if (ring.size < kFewest || ring.surely_within(slopes(u, v), least)) continue;
      const double excess = slopes(u, v) - ring.median();
      if (std::abs(excess) > least) result(u, v) = excess;
    }
  });
  return result;
}

// The error of a sample's normal. Windows at the border of a patch are half inside: the error is
// that of the window near by that shows it best, if it is beyond the limit.
double error_at(const Grid<double>& excess, int u, int v, int half, double limit) {
  double largest = excess(u, v);
  if (largest == 0.0) return 0.0;
  for (int y = std::max(0, v - half); y <= std::min(excess.height() - 1, v + half); ++y)
    for (int x = std::max(0, u - half); x <= std::min(excess.width() - 1, u + half); ++x)
      if (std::abs(excess(x, y)) > std::abs(largest)) largest = excess(x, y);
  return std::abs(largest) > limit && excess(u, v) / largest > 0.5 ? largest : 0.0;
}

}  // namespace

CoherentErrors coherent_errors(const ViewProblem& problem, const NoiseEstimate& noise,
                               double spacing) {
  const int half = window_for(noise, spacing);
  const double variance = mean_variance(2.0 * half * (2 * half + 1), half, noise, spacing);
  const double change = noise.bias_gradient * kRing * half;
  const double limit = kDeviations * std::sqrt(1.3 * variance + change * change);
  const auto count = static_cast<Eigen::Index>(problem.size());
  CoherentErrors errors{Eigen::VectorXd::Zero(2 * count), 0};
  for (const std::size_t axis : {0u, 1u}) {
    const Grid<double> excess =
        contradictions(window_slopes(problem, axis, half), half, 0.5 * limit);
    for_each_sample(problem, [&](Eigen::Index k, std::uint32_t pixel) {
      errors.slopes[static_cast<Eigen::Index>(axis) * count + k] =
          error_at(excess, problem.grid.u(pixel), problem.grid.v(pixel), half, limit);
    });
  }
  for (Eigen::Index k = 0; k < count; ++k)
    errors.samples += errors.slopes[k] != 0.0 || errors.slopes[count + k] != 0.0;
  return errors;
}

}  // namespace relief::hybrid
