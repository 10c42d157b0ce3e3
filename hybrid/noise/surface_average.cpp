#include "hybrid/noise/surface_average.h"

#include <cmath>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kColumnsAtOnce = 64;  // Of one piece of work; changes no result.

// What is summed at a pixel, and the weight of that sum.
struct WeightedSum {
  float value = 0.0f, weight = 0.0f;
};
WeightedSum operator+(const WeightedSum& a, const WeightedSum& b) {
  return {a.value + b.value, a.weight + b.weight};
}
WeightedSum operator*(float factor, const WeightedSum& sum) {
  return {factor * sum.value, factor * sum.weight};
}

}  // namespace

SurfaceAverage::SurfaceAverage(const ViewProblem& problem)
    : problem_(problem), right_(problem.grid.size(), 0), down_(right_) {
  for_each_bias_pair(problem, [&](std::size_t tail, std::size_t head) {
    (head - tail == 1 ? right_ : down_)[tail] = 1;
  });
}

// Exponential averaging is a recursion from either side. A cut between two pixels ends it.
template <typename Sum>
void SurfaceAverage::sum_row(std::size_t first, float decay, std::vector<Sum>& plane) const {
  const auto width = static_cast<std::size_t>(problem_.grid.width);
  std::vector<Sum> before(width, Sum());
  for (std::size_t u = 1; u < width; ++u)
    before[u] = decay * right_[first + u - 1] * (plane[first + u - 1] + before[u - 1]);
  Sum behind = Sum();
  for (std::size_t u = width; u-- > 0;) {
    const Sum own = plane[first + u];
    behind = decay * right_[first + u] * behind;
    plane[first + u] = own + before[u] + behind;
    behind = own + behind;
  }
}

// The same for columns [begin, end), row by row for the sake of the cache.
template <typename Sum>
void SurfaceAverage::sum_columns(std::size_t begin, std::size_t end, float decay,
                                 std::vector<Sum>& plane) const {
  const PaddedGrid& grid = problem_.grid;
  const std::size_t count = end - begin, stride = static_cast<std::size_t>(grid.stride());
  const auto height = static_cast<std::size_t>(grid.height);
  const std::size_t corner = grid.index(0, 0) + begin;
  std::vector<Sum> before(height * count, Sum()), below(count, Sum());
  for (std::size_t v = 1; v < height; ++v)
    for (std::size_t u = 0, i = corner + (v - 1) * stride; u < count; ++u, ++i)
      before[v * count + u] = decay * down_[i] * (plane[i] + before[(v - 1) * count + u]);
  for (std::size_t v = height; v-- > 0;) {
    for (std::size_t u = 0, i = corner + v * stride; u < count; ++u, ++i) {
      const Sum own = plane[i], behind = decay * down_[i] * below[u];
      plane[i] = own + before[v * count + u] + behind;
      below[u] = own + behind;
    }
  }
}

template <typename Sum>
void SurfaceAverage::sum_up(std::vector<Sum>& plane, double window) const {
  const auto decay = static_cast<float>(std::exp(-1.0 / window));
  parallel_rows(problem_.grid.height,
                [&](int v) { sum_row(problem_.grid.index(0, v), decay, plane); });
  parallel_for(static_cast<std::size_t>(problem_.grid.width), kColumnsAtOnce,
               [&](std::size_t begin, std::size_t end) { sum_columns(begin, end, decay, plane); });
}

Eigen::VectorXf SurfaceAverage::average(const Eigen::VectorXf& values, double window) const {
  std::vector<WeightedSum> plane(problem_.grid.size());
  for_each_sample(problem_, [&](Eigen::Index k, std::size_t i) { plane[i] = {values[k], 1.0f}; });
  sum_up(plane, window);
  Eigen::VectorXf averages(values.size());
  for_each_sample(problem_, [&](Eigen::Index k, std::size_t i) {
    averages[k] = plane[i].value / plane[i].weight;
  });
  return averages;
}

Eigen::VectorXf SurfaceAverage::share(double window) const {
  std::vector<float> plane(problem_.grid.size(), 0.0f);
  for_each_sample(problem_, [&](Eigen::Index, std::size_t i) { plane[i] = 1.0f; });
  sum_up(plane, window);
  const double decay = std::exp(-1.0 / window), line = (1.0 + decay) / (1.0 - decay);
  const auto all = static_cast<float>(line * line);
  Eigen::VectorXf shares(static_cast<Eigen::Index>(problem_.size()));
  for_each_sample(problem_, [&](Eigen::Index k, std::size_t i) { shares[k] = plane[i] / all; });
  return shares;
}

}  // namespace relief::hybrid
