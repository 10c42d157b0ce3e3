#include "hybrid/model/smooth_change.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "scan/base/linear_algebra.h"

namespace relief::hybrid {

namespace {

constexpr int kSide = 8;  // Of a block [samples]: its mean has an eighth of the samples' noise.
// Fraction of the blocks, those of the largest changes: so much of a view may have wrong normals
// without a contradiction.
constexpr double kLeftOut = 0.1;
constexpr double kLeast = 0.5 * kSide * kSide;  // Samples of a block that counts: half of it.

// Sums over the samples of a block, of (1, u, v) and the change.
struct Block {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d rhs = Eigen::Vector3d::Zero();
  double squares = 0.0;

  void add(int u, int v, double change) {
    const Eigen::Vector3d place(1.0, u, v);
    matrix += place * place.transpose();
    rhs += change * place;
    squares += change * change;
  }
  double count() const { return matrix(0, 0); }
  double mean() const { return rhs[0] / count(); }
  // Variance of the samples about the plane.
  double scatter() const {
    const Eigen::Vector3d plane = solve_symmetric(matrix, rhs);
    return std::max(0.0, squares - plane.dot(rhs)) / (count() - 3.0);
  }
};

}  // namespace

SmoothChange smooth_change(const ViewProblem& problem, const Eigen::VectorXd& x, double step) {
  const PaddedGrid& grid = problem.grid;
  Grid<Block> blocks((grid.width + kSide - 1) / kSide, (grid.height + kSide - 1) / kSide);
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    if (!(problem.confidence[at] > 0.0f)) continue;
    const int u = grid.u(problem.pixels[k]), v = grid.v(problem.pixels[k]);
    blocks(u / kSide, v / kSide).add(u % kSide, v % kSide, x[at]);
  }
  std::vector<std::pair<double, double>> changes;  // Squared, of the mean and about the plane.
  for (const Block& block : blocks) {
    if (block.count() < kLeast) continue;
    const double mean = std::max(0.0, std::abs(block.mean()) - 0.5 * step);
    const double scatter = block.scatter();
    changes.emplace_back(mean * mean - scatter / block.count(), scatter);
  }
  if (changes.empty()) return {};
  std::sort(changes.begin(), changes.end());
  const auto kept = std::max<std::size_t>(
      1, static_cast<std::size_t>((1.0 - kLeftOut) * static_cast<double>(changes.size())));
  double between = 0.0, within = 0.0;
  for (std::size_t k = 0; k < kept; ++k) {
    between += changes[k].first;
    within += changes[k].second;
  }
  const auto rms = [&](double sum) {
    return std::sqrt(std::max(0.0, sum / static_cast<double>(kept)));
  };
  return {rms(between), rms(within)};
}

}  // namespace relief::hybrid
