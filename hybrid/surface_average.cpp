#include "hybrid/surface_average.h"

#include <cmath>
#include <vector>

#include "scan/parallel.h"

namespace relief {

namespace {

constexpr std::size_t kLinesAtOnce = 64;

}  // namespace

SurfaceAverage::SurfaceAverage(const ViewProblem& problem, int threads)
    : problem_(problem),
      threads_(threads),
      right_(problem.grid.width, problem.grid.height, 0),
      down_(right_) {
  for (const auto& [a, b] : bias_neighbours(problem)) {
    const std::uint32_t tail = problem.pixels[a], head = problem.pixels[b];
    Grid<std::uint8_t>& joined = head - tail == 1 ? right_ : down_;
    joined(problem.grid.u(tail), problem.grid.v(tail)) = 1;
  }
}

// Exponential averaging is a recursion from either side. A cut between two pixels ends it.
void SurfaceAverage::sum_row(int v, double decay, Grid<Sum>& sums) const {
  const int width = sums.width();
  std::vector<Sum> before(static_cast<std::size_t>(width));
  for (int u = 1; u < width; ++u)
    before[static_cast<std::size_t>(u)] =
        (sums(u - 1, v) + before[static_cast<std::size_t>(u) - 1]).times(decay * right_(u - 1, v));
  Sum behind;
  for (int u = width - 1; u >= 0; --u) {
    const Sum own = sums(u, v);
    behind = behind.times(decay * right_(u, v));
    sums(u, v) = own + before[static_cast<std::size_t>(u)] + behind;
    behind = own + behind;
  }
}

// The same for columns [begin, end), row by row for the sake of the cache.
void SurfaceAverage::sum_columns(int begin, int end, double decay, Grid<Sum>& before,
                                 Grid<Sum>& sums) const {
  for (int v = 1; v < sums.height(); ++v)
    for (int u = begin; u < end; ++u)
      before(u, v) = (sums(u, v - 1) + before(u, v - 1)).times(decay * down_(u, v - 1));
  std::vector<Sum> below(static_cast<std::size_t>(end - begin));
  for (int v = sums.height() - 1; v >= 0; --v) {
    for (int u = begin; u < end; ++u) {
      Sum& behind = below[static_cast<std::size_t>(u - begin)];
      const Sum own = sums(u, v);
      behind = behind.times(decay * down_(u, v));
      sums(u, v) = own + before(u, v) + behind;
      behind = own + behind;
    }
  }
}

Grid<SurfaceAverage::Sum> SurfaceAverage::sums(const Eigen::VectorXd& values, double window) const {
  const PaddedGrid& grid = problem_.grid;
  const double decay = std::exp(-1.0 / window);
  Grid<Sum> sums(grid.width, grid.height), before = sums;
  for (std::size_t k = 0; k < problem_.size(); ++k) {
    const std::uint32_t i = problem_.pixels[k];
    sums(grid.u(i), grid.v(i)) = {values[static_cast<Eigen::Index>(k)], 1.0};
  }
  parallel_for(static_cast<std::size_t>(grid.height), kLinesAtOnce, threads_,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t v = begin; v < end; ++v)
                   sum_row(static_cast<int>(v), decay, sums);
               });
  parallel_for(static_cast<std::size_t>(grid.width), kLinesAtOnce, threads_,
               [&](std::size_t begin, std::size_t end) {
                 sum_columns(static_cast<int>(begin), static_cast<int>(end), decay, before, sums);
               });
  return sums;
}

template <typename Value>
Eigen::VectorXd SurfaceAverage::each_sample(const Grid<Sum>& sums, const Value& value) const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(problem_.size()));
  for (std::size_t k = 0; k < problem_.size(); ++k) {
    const std::uint32_t i = problem_.pixels[k];
    values[static_cast<Eigen::Index>(k)] = value(sums(problem_.grid.u(i), problem_.grid.v(i)));
  }
  return values;
}

Eigen::VectorXd SurfaceAverage::average(const Eigen::VectorXd& values, double window) const {
  return each_sample(sums(values, window), [](const Sum& sum) { return sum.value / sum.weight; });
}

Eigen::VectorXd SurfaceAverage::share(double window) const {
  const auto count = static_cast<Eigen::Index>(problem_.size());
  const double decay = std::exp(-1.0 / window), line = (1.0 + decay) / (1.0 - decay);
  return each_sample(sums(Eigen::VectorXd::Ones(count), window),
                     [&](const Sum& sum) { return sum.weight / (line * line); });
}

}  // namespace relief
