#include "hybrid/noise/surface_average.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kColumnsAtOnce = 64;  // Of one piece of work; changes no result.
// Cells along a window, at least: weights change by exp(-1/8) along a cell at most.
constexpr double kCellsOfWindow = 8.0;

// What is summed at a cell, and the weight of that sum.
struct WeightedSum {
  float value = 0.0f, weight = 0.0f;
};
WeightedSum operator+(const WeightedSum& a, const WeightedSum& b) {
  return {a.value + b.value, a.weight + b.weight};
}
WeightedSum operator*(float factor, const WeightedSum& sum) {
  return {factor * sum.value, factor * sum.weight};
}

// Which cells of a grid hang together with the next along rows and columns, and how much the
// weight of a sum falls from one to the next.
struct Connections {
  const PaddedGrid& grid;
  const std::vector<std::uint8_t>&right, &down;
  float decay;
};

// Exponential averaging is a recursion from either side. A cut between two cells ends it.
template <typename Sum>
void sum_row(const Connections& of, std::size_t first, std::vector<Sum>& plane) {
  const auto width = static_cast<std::size_t>(of.grid.width);
  std::vector<Sum> before(width, Sum());
  for (std::size_t u = 1; u < width; ++u)
    before[u] = of.decay * of.right[first + u - 1] * (plane[first + u - 1] + before[u - 1]);
  Sum behind = Sum();
  for (std::size_t u = width; u-- > 0;) {
    const Sum own = plane[first + u];
    behind = of.decay * of.right[first + u] * behind;
    plane[first + u] = own + before[u] + behind;
    behind = own + behind;
  }
}

// The same for columns [begin, end), row by row for the sake of the cache.
template <typename Sum>
void sum_columns(const Connections& of, std::size_t begin, std::size_t end,
                 std::vector<Sum>& plane) {
  const std::size_t count = end - begin, stride = static_cast<std::size_t>(of.grid.stride());
  const auto height = static_cast<std::size_t>(of.grid.height);
  const std::size_t corner = of.grid.index(0, 0) + begin;
  std::vector<Sum> before(height * count, Sum()), below(count, Sum());
  for (std::size_t v = 1; v < height; ++v)
    for (std::size_t u = 0, i = corner + (v - 1) * stride; u < count; ++u, ++i)
      before[v * count + u] = of.decay * of.down[i] * (plane[i] + before[(v - 1) * count + u]);
  for (std::size_t v = height; v-- > 0;) {
    for (std::size_t u = 0, i = corner + v * stride; u < count; ++u, ++i) {
      const Sum own = plane[i], behind = of.decay * of.down[i] * below[u];
      plane[i] = own + before[v * count + u] + behind;
      below[u] = own + behind;
    }
  }
}

template <typename Sum>
void sum_rows(const Connections& of, std::vector<Sum>& plane) {
  parallel_rows(of.grid.height, [&](int v) { sum_row(of, of.grid.index(0, v), plane); });
}

template <typename Sum>
void sum_columns(const Connections& of, std::vector<Sum>& plane) {
  parallel_for(static_cast<std::size_t>(of.grid.width), kColumnsAtOnce,
               [&](std::size_t begin, std::size_t end) { sum_columns(of, begin, end, plane); });
}

// What reaches each cell along rows and then columns, and along columns and then rows: the other
// way round goes past a hole that stops one of them.
template <typename Sum>
std::array<std::vector<Sum>, 2> sums_in_both_orders(const Connections& of,
                                                    const std::vector<Sum>& plane) {
  std::array<std::vector<Sum>, 2> sums{plane, plane};
  sum_rows(of, sums[0]);
  sum_columns(of, sums[0]);
  sum_columns(of, sums[1]);
  sum_rows(of, sums[1]);
  return sums;
}

// The level for a window, where there are as many.
std::size_t level_of(double window) {
  return static_cast<std::size_t>(std::max(0.0, std::floor(std::log2(window / kCellsOfWindow))));
}

float decay_of(double window, std::size_t level) {
  return static_cast<float>(std::exp(-std::ldexp(1.0, static_cast<int>(level)) / window));
}

}  // namespace

SurfaceAverage::SurfaceAverage(const ViewProblem& problem, double largest_window)
    : problem_(problem), levels_(1) {
  Level& pixels = levels_.front();
  pixels.grid = problem.grid;
  pixels.samples.assign(problem.grid.size(), 0.0f);
  pixels.right.assign(problem.grid.size(), 0);
  pixels.down = pixels.right;
  for_each_sample(problem, [&](Eigen::Index, std::size_t i) { pixels.samples[i] = 1.0f; });
  for_each_bias_pair(problem, [&](std::size_t tail, std::size_t head) {
    (head - tail == 1 ? pixels.right : pixels.down)[tail] = 1;
  });
  while (levels_.size() <= level_of(largest_window) &&
         std::max(levels_.back().grid.width, levels_.back().grid.height) > kCellsOfWindow)
    levels_.push_back(coarsened(levels_.back()));
}

SurfaceAverage::Level SurfaceAverage::coarsened(Level& fine) {
  Level coarse;
  coarse.grid = {(fine.grid.width + 1) / 2, (fine.grid.height + 1) / 2};
  coarse.samples.assign(coarse.grid.size(), 0.0f);
  coarse.right.assign(coarse.grid.size(), 0);
  coarse.down = coarse.right;
  choose_largest_parts(fine, coarse.grid);
  join_smaller_parts(fine);
  for (std::size_t i = 0; i < fine.samples.size(); ++i) {
    const std::uint32_t cell = fine.coarser[i];
    if (cell == kNone) continue;
    coarse.samples[cell] += fine.samples[i];
    if (fine.right[i] && fine.coarser[i + 1] == cell + 1) coarse.right[cell] = 1;
    if (fine.down[i] && fine.coarser[i + fine.grid.stride()] == cell + coarse.grid.stride())
      coarse.down[cell] = 1;
  }
  return coarse;
}

// Of the up to four cells in one, those of the largest part that hangs together stand for it.
void SurfaceAverage::choose_largest_parts(Level& fine, const PaddedGrid& coarse) {
  fine.coarser.assign(fine.grid.size(), kNone);
  for (int v = 0; v < fine.grid.height; v += 2)
    for (int u = 0; u < fine.grid.width; u += 2) {
      // Padding to the right and below holds no samples.
      const std::size_t first = fine.grid.index(u, v), below = first + fine.grid.stride();
      const std::array<std::size_t, 4> cells = {first, first + 1, below, below + 1};
      std::array<std::size_t, 4> part = {0, 1, 2, 3};
      const auto join_if = [&](bool connected, std::size_t a, std::size_t b) {
        if (connected) std::replace(part.begin(), part.end(), part[b], part[a]);
      };
      join_if(fine.right[first], 0, 1);
      join_if(fine.down[first], 0, 2);
      join_if(fine.down[first + 1], 1, 3);
      join_if(fine.right[below], 2, 3);
      std::array<float, 4> samples{};
      for (std::size_t c = 0; c < 4; ++c) samples[part[c]] += fine.samples[cells[c]];
      const auto largest = static_cast<std::size_t>(
          std::max_element(samples.begin(), samples.end()) - samples.begin());
      for (std::size_t c = 0; c < 4; ++c)
        if (part[c] == largest && fine.samples[cells[c]] > 0.0f)
          fine.coarser[cells[c]] = coarse.index(u / 2, v / 2);
    }
}

// Smaller parts join a part of a cell beside theirs with which they hang together.
void SurfaceAverage::join_smaller_parts(Level& fine) {
  const std::vector<std::uint32_t> largest = fine.coarser;
  const auto stride = static_cast<std::size_t>(fine.grid.stride());
  for (std::size_t i = stride; i + stride < largest.size(); ++i) {
    if (largest[i] != kNone || !(fine.samples[i] > 0.0f)) continue;
    std::uint32_t& cell = fine.coarser[i];
    if (cell == kNone && fine.right[i]) cell = largest[i + 1];
    if (cell == kNone && fine.right[i - 1]) cell = largest[i - 1];
    if (cell == kNone && fine.down[i]) cell = largest[i + stride];
    if (cell == kNone && fine.down[i - stride]) cell = largest[i - stride];
  }
}

SurfaceAverage::Place SurfaceAverage::place_of(std::size_t pixel, std::size_t coarsest) const {
  Place place{0, pixel};
  while (place.level < coarsest) {
    const std::uint32_t cell = levels_[place.level].coarser[place.cell];
    if (cell == kNone) break;
    place = {place.level + 1, cell};
  }
  return place;
}

Eigen::VectorXf SurfaceAverage::average(const Eigen::VectorXf& values, double window) const {
  const std::size_t coarsest = std::min(levels_.size() - 1, level_of(window));
  std::vector<std::vector<WeightedSum>> sums(coarsest + 1);
  sums[0].resize(problem_.grid.size());
  for_each_sample(problem_, [&](Eigen::Index k, std::size_t i) { sums[0][i] = {values[k], 1.0f}; });
  for (std::size_t l = 0; l < coarsest; ++l) {
    sums[l + 1].resize(levels_[l + 1].grid.size());
    for (std::size_t i = 0; i < sums[l].size(); ++i)
      if (const std::uint32_t cell = levels_[l].coarser[i]; cell != kNone)
        sums[l + 1][cell] = sums[l + 1][cell] + sums[l][i];
  }
  for (std::size_t l = 0; l <= coarsest; ++l) {
    const Connections of{levels_[l].grid, levels_[l].right, levels_[l].down, decay_of(window, l)};
    const auto both = sums_in_both_orders(of, sums[l]);
    for (std::size_t i = 0; i < sums[l].size(); ++i) sums[l][i] = both[0][i] + both[1][i];
  }
  Eigen::VectorXf averages(values.size());
  for_each_sample(problem_, [&](Eigen::Index k, std::size_t i) {
    const Place place = place_of(i, coarsest);
    const WeightedSum& sum = sums[place.level][place.cell];
    averages[k] = sum.value / sum.weight;
  });
  return averages;
}

Eigen::VectorXf SurfaceAverage::share(double window) const {
  const std::size_t coarsest = std::min(levels_.size() - 1, level_of(window));
  std::vector<std::vector<float>> shares(coarsest + 1);
  for (std::size_t l = 0; l <= coarsest; ++l) {
    const float decay = decay_of(window, l);
    const Connections of{levels_[l].grid, levels_[l].right, levels_[l].down, decay};
    const auto both = sums_in_both_orders(of, levels_[l].samples);
    const float line = (1.0f + decay) / (1.0f - decay);
    const float all = line * line * std::ldexp(1.0f, 2 * static_cast<int>(l));
    shares[l].resize(both[0].size());
    for (std::size_t i = 0; i < both[0].size(); ++i)
      shares[l][i] = std::max(both[0][i], both[1][i]) / all;
  }
  Eigen::VectorXf result(static_cast<Eigen::Index>(problem_.size()));
  for_each_sample(problem_, [&](Eigen::Index k, std::size_t i) {
    const Place place = place_of(i, coarsest);
    result[k] = shares[place.level][place.cell];
  });
  return result;
}

}  // namespace relief::hybrid
