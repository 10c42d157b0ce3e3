#include "hybrid/solver/bias_roughness.h"

#include <algorithm>
#include <cmath>

#include "hybrid/model/rectangle_sums.h"
#include "scan/base/median.h"

namespace relief::hybrid {

namespace {

// Half width of the windows [samples]. 4 and 16 give refined ranges that are as good within 2 %
// (docs/results.md, Normals that err unevenly).
constexpr int kHalfWindow = 8;

// Squared changes of the bias between each sample and its neighbours, and how many of them, padded.
struct SquaredChanges {
  std::vector<float> sum, count;
};

SquaredChanges squared_changes(const ViewProblem& problem, const Eigen::VectorXd& y) {
  const auto samples = static_cast<Eigen::Index>(problem.size());
  const std::vector<std::uint32_t> number = numbers_of(problem);
  SquaredChanges changes{std::vector<float>(problem.grid.size(), 0.0f),
                         std::vector<float>(problem.grid.size(), 0.0f)};
  for_each_bias_pair(problem, [&](std::size_t a, std::size_t b) {
    double squared = 0.0;
    for (const Eigen::Index block : {samples, 2 * samples})
      squared += std::pow(y[block + number[a]] - y[block + number[b]], 2);
    for (const std::size_t end : {a, b}) {
      changes.sum[end] += static_cast<float>(squared);
      changes.count[end] += 1.0f;
    }
  });
  return changes;
}

}  // namespace

std::vector<float> bias_roughness(const ViewProblem& problem, const Eigen::VectorXd& y) {
  if (y.size() <= static_cast<Eigen::Index>(problem.size())) return {};
  const SquaredChanges changes = squared_changes(problem, y);
  const RectangleSums sums(problem.grid, [&](std::size_t i) { return double{changes.sum[i]}; });
  const RectangleSums counts(problem.grid, [&](std::size_t i) { return double{changes.count[i]}; });
  std::vector<float> mean(problem.size(), 0.0f);
  for_each_sample(problem, [&](Eigen::Index k, std::uint32_t pixel) {
    const int u = problem.grid.u(pixel), v = problem.grid.v(pixel);
    const auto window = [&](const RectangleSums& of) {
      return of(u - kHalfWindow, u + kHalfWindow + 1, v - kHalfWindow, v + kHalfWindow + 1);
    };
    const double count = window(counts);
    if (count > 0.0) mean[static_cast<std::size_t>(k)] = static_cast<float>(window(sums) / count);
  });
  std::vector<float> sorted = mean;
  const float typical = median(sorted);
  if (!(typical > 0.0f)) return {};
  for (float& value : mean) value = std::max(1.0f, value / typical);
  return mean;
}

}  // namespace relief::hybrid
