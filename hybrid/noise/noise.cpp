#include "hybrid/noise/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "hybrid/noise/coarse_steps.h"
#include "scan/base/gaussian_core.h"
#include "scan/base/median.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

// Second differences between blocks from which a variance is good to a tenth (sqrt(2 / n)).
constexpr std::size_t kFewestBlocks = 200;

constexpr std::size_t kValuesAtOnce = 1 << 14;  // Of one piece of work, summed in order.

// Iterations to a fixed point end when it changes by less than this part: a thousandth of the
// percent that samples tell it to.
constexpr double kSettled = 1e-5;

// Standard deviation of the Gaussian core of `values`: the fixed point of the second moment of what
// lies within two standard deviations.
double core_sigma(std::vector<double> values) {
  if (values.empty()) return 0.0;
  for (double& value : values) value = std::abs(value);
  double sigma = starting_sigma(values);
  for (int round = 0; round < 30; ++round) {
    const auto moments_of = [&](std::size_t begin, std::size_t end) {
      Eigen::Array2d sums = Eigen::Array2d::Zero();  // of squares, of ones
      for (std::size_t k = begin; k < end; ++k)
        if (values[k] < kCoreCut * sigma) sums += Eigen::Array2d(values[k] * values[k], 1.0);
      return sums;
    };
    const Eigen::Array2d sums =
        parallel_sum(values.size(), kValuesAtOnce, Eigen::Array2d::Zero().eval(), moments_of);
    if (!(sums[0] > 0.0)) break;
    const double before = std::exchange(sigma, std::sqrt(sums[0] / sums[1] / kCoreMoment));
    if (std::abs(sigma - before) <= kSettled * sigma) break;
  }
  return sigma;
}

// Sums over a straight walk of edges. Node n of the walk enters with the mean of the sensitivities
// of its two edges, so that `node_squares` times the variance of a slope is that of the sum.
struct WalkSums {
  double discrepancy = 0.0, expected = 0.0;
  double sensitivity = 0.0;        // sum of the edges' sensitivities
  double node_squares = 0.0;       // sum of squares of the nodes' sensitivities
  double first = 0.0, last = 0.0;  // sensitivities of the end edges
};

// What a node at the end of a walk has of the square of its edge's sensitivity, and of twice the
// product of those of two edges that it belongs to. Half of an edge squared for a sample; through a
// block of samples the sensitivity rises evenly.
double end_share(const RangeSteps::Direction& steps) {
  return 1.0 / 3.0 - 1.0 / (12.0 * steps.factor * steps.factor);
}
double overlap_share(const RangeSteps::Direction& steps) {
  return 1.0 / 6.0 + 1.0 / (12.0 * steps.factor * steps.factor);
}

WalkSums walk(const RangeSteps::Direction& direction, int u, int v, int du, int dv, int edges) {
  WalkSums sums;
  double before = 0.0;
  for (int k = 0; k < edges; ++k) {
    const int eu = u + k * du, ev = v + k * dv;
    const double sensitivity = direction.sensitivity(eu, ev);
    sums.discrepancy += direction.discrepancy(eu, ev);
    sums.expected += direction.expected(eu, ev);
    sums.sensitivity += sensitivity;
    if (k == 0)
      sums.first = sensitivity;
    else
      sums.node_squares += 0.25 * (before + sensitivity) * (before + sensitivity);
    before = sensitivity;
  }
  sums.last = before;
  sums.node_squares += end_share(direction) * (sums.first * sums.first + sums.last * sums.last);
  return sums;  // NaN anywhere on the walk makes every sum NaN
}

// In edges. Over more than about eight samples a bias is no longer told from noise by how it grows.
int longest_walk(const RangeSteps& steps) { return std::max(2, 8 / steps.along_rows.factor); }

// Calls visit(direction, u, v, du, dv) for every start of a walk that stays inside the grid.
template <typename Visit>
void for_each_walk(const RangeSteps& steps, int length, int stride, const Visit& visit) {
  const int width = steps.along_rows.expected.width();
  const int height = steps.along_rows.expected.height();
  for (int v = 0; v < height; v += stride)
    for (int u = 0; u + length < width; u += stride) visit(steps.along_rows, u, v, 1, 0);
  for (int v = 0; v + length < height; v += stride)
    for (int u = 0; u < width; u += stride) visit(steps.along_columns, u, v, 0, 1);
}

// Calls visit(n, lengths[n]) for every length of walks.
template <std::size_t kCount, typename Visit>
void each(const std::array<int, kCount>& lengths, const Visit& visit) {
  parallel_for(kCount, 1, [&](std::size_t n, std::size_t) { visit(n, lengths[n]); });
}

// Samples of a grid to step over such that a statistic has enough.
int thinning(const RangeSteps& steps) {
  // Bounds the time. As many values tell a standard deviation to 1 / sqrt(2 n) = 0.3 %; to 0.9 % if
  // only one in nine is independent.
  constexpr double kEnough = 60000.0;
  return std::max(
      1,
      static_cast<int>(std::sqrt(static_cast<double>(steps.along_rows.expected.size()) / kEnough)));
}

// Equation (H7): round a loop of k x k cells the expected steps close up but for the noise of the
// normals. Closures are divided by their sensitivity: values of standard deviation sigma_normal.
std::vector<double> loop_closures(const RangeSteps& steps, int k) {
  std::vector<double> closures;
  const auto& rows = steps.along_rows;
  const auto& columns = steps.along_columns;
  const int stride = thinning(steps);
  for (int v = 0; v + k < rows.expected.height(); v += stride) {
    for (int u = 0; u + k < rows.expected.width(); u += stride) {
      const WalkSums top = walk(rows, u, v, 1, 0, k), bottom = walk(rows, u, v + k, 1, 0, k);
      const WalkSums left = walk(columns, u, v, 0, 1, k), right = walk(columns, u + k, v, 0, 1, k);
      const double closure = top.expected + right.expected - bottom.expected - left.expected;
      const double squares =
          top.node_squares + right.node_squares + bottom.node_squares + left.node_squares;
      if (closure == closure && squares > 0.0) closures.push_back(closure / std::sqrt(squares));
    }
  }
  return closures;
}

// The white part of the closures' variance over loops of growing size; a curl of the bias grows
// with the cube of the size and is fitted away.
double normal_noise(const RangeSteps& steps) {
  constexpr std::array<int, 3> kSides{1, 2, 4};  // [samples]
  std::array<double, kSides.size()> sigmas{};
  each(kSides, [&](std::size_t n, int k) {
    if (k <= longest_walk(steps)) sigmas[n] = core_sigma(loop_closures(steps, k));
  });
  Eigen::Matrix2d normal_matrix = Eigen::Matrix2d::Zero();
  Eigen::Vector2d rhs = Eigen::Vector2d::Zero();
  double first = 0.0;
  for (std::size_t n = 0; n < kSides.size(); ++n) {
    const double sigma = sigmas[n], k = kSides[n];
    if (sigma <= 0.0) continue;
    if (first == 0.0) first = sigma * sigma;
    const Eigen::Vector2d model(1.0, k * k * k);
    const double weight = 1.0 / std::pow(sigma, 4);
    normal_matrix += weight * model * model.transpose();
    rhs += weight * model * (sigma * sigma);
  }
  const Eigen::Vector2d fit = normal_matrix.ldlt().solve(rhs);
  const double variance = fit.allFinite() && fit[1] > 0.0 && fit[0] > 0.0 ? fit[0] : first;
  return std::sqrt(variance);
}

// The discrepancy over k edges less that over the k edges before, and the terms of its expected
// square, equation (H8): 6 sigma_position^2 + nodes sigma_normal^2 + area^2 bias_gradient^2.
struct SecondDifference {
  double value, nodes, area;
};

SecondDifference second_difference(const RangeSteps::Direction& direction, int u, int v, int du,
                                   int dv, int k) {
  const WalkSums first = walk(direction, u, v, du, dv, k);
  const WalkSums second = walk(direction, u + k * du, v + k * dv, du, dv, k);
  // The node in the middle belongs to both walks, with opposite signs.
  const double nodes = first.node_squares + second.node_squares -
                       2.0 * overlap_share(direction) * first.last * second.first;
  return {second.discrepancy - first.discrepancy, nodes,
          0.5 * k * (first.sensitivity + second.sensitivity)};
}

std::vector<SecondDifference> second_differences(const RangeSteps& steps) {
  constexpr std::array<int, 6> kLengths{1, 2, 3, 4, 6, 8};  // [edges], up to longest_walk()
  std::array<std::vector<SecondDifference>, kLengths.size()> by_length;
  each(kLengths, [&](std::size_t n, int k) {
    if (k > longest_walk(steps)) return;
    const auto visit = [&](const auto& direction, int u, int v, int du, int dv) {
      const SecondDifference d = second_difference(direction, u, v, du, dv, k);
      if (d.value == d.value) by_length[n].push_back(d);
    };
    for_each_walk(steps, 2 * k, thinning(steps), visit);
  });
  std::vector<SecondDifference> differences;
  for (const auto& of_length : by_length)
    differences.insert(differences.end(), of_length.begin(), of_length.end());
  return differences;
}

struct WalkFit {
  double position_variance = 0.0, normal_variance = 0.0, gradient_variance = 0.0;
};

// The normal equations of a moment fit.
struct Moments {
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
  Eigen::Vector2d rhs = Eigen::Vector2d::Zero();
  Moments& operator+=(const Moments& other) {
    matrix += other.matrix;
    rhs += other.rhs;
    return *this;
  }
};

// Those of (H8) for differences [begin, end) weighted by the model `fit`; squares beyond nine times
// their model are outliers.
Moments moments_of(const std::vector<SecondDifference>& differences, const WalkFit& fit,
                   std::size_t begin, std::size_t end) {
  // [variances], E[z^2; z^2 < 9] / P[z^2 < 9] of a Gaussian z
  constexpr double kCut = 9.0, kKeptMoment = 0.9733;
  Moments moments;
  for (std::size_t k = begin; k < end; ++k) {
    const SecondDifference& d = differences[k];
    const double expected = 6.0 * fit.position_variance + d.nodes * fit.normal_variance +
                            d.area * d.area * fit.gradient_variance;
    if (!(d.value * d.value < kCut * expected)) continue;
    const double weight = 1.0 / (expected * expected);
    const Eigen::Vector2d model(6.0, d.area * d.area);
    moments.matrix += weight * model * model.transpose();
    moments.rhs +=
        weight * model * (d.value * d.value / kKeptMoment - d.nodes * fit.normal_variance);
  }
  return moments;
}

// Moment fit of (H8) with known normal noise.
WalkFit fit_second_differences(const std::vector<SecondDifference>& differences,
                               double normal_variance) {
  std::vector<double> whitened;  // as if all were position noise
  whitened.reserve(differences.size());
  for (const auto& d : differences)
    whitened.push_back(
        std::sqrt(std::max(0.0, d.value * d.value - d.nodes * normal_variance) / 6.0));
  const double start = core_sigma(std::move(whitened));
  WalkFit fit{start * start, normal_variance, 0.0};
  for (int round = 0; round < 20; ++round) {
    const Moments moments = parallel_sum(differences.size(), kValuesAtOnce, Moments(),
                                         [&](std::size_t begin, std::size_t end) {
                                           return moments_of(differences, fit, begin, end);
                                         });
    Eigen::Vector2d next = moments.matrix.ldlt().solve(moments.rhs);
    if (!(next[1] > 0.0)) next = {moments.rhs[0] / moments.matrix(0, 0), 0.0};
    if (!next.allFinite()) break;
    next[0] = std::max(next[0], 1e-6 * start * start);
    const bool settled = std::abs(next[0] - fit.position_variance) <= kSettled * next[0] &&
                         std::abs(next[1] - fit.gradient_variance) <= kSettled * std::abs(next[1]);
    fit.position_variance = next[0];
    fit.gradient_variance = next[1];
    if (settled) break;
  }
  return fit;
}

// The fit of (H8) to steps between blocks.
struct BlockFit {
  std::size_t differences = 0;
  WalkFit fit;
  bool positions_rule = false;  // in half of the differences, those between close blocks
};

BlockFit fit_blocks(const RangeSteps& steps) {
  BlockFit block;
  const std::vector<SecondDifference> differences = second_differences(steps);
  block.differences = differences.size();
  if (differences.size() < kFewestBlocks) return block;
  const double normal = normal_noise(steps);
  block.fit = fit_second_differences(differences, normal * normal);
  const auto position_rules = [&](const SecondDifference& d) {
    return 6.0 * block.fit.position_variance >
           d.nodes * block.fit.normal_variance + d.area * d.area * block.fit.gradient_variance;
  };
  const auto ruled = std::count_if(differences.begin(), differences.end(), position_rules);
  block.positions_rule = 2 * static_cast<std::size_t>(ruled) >= differences.size();
  return block;
}

// The variance that independent noise of the ranges would have to have, to do as much harm as
// theirs does over long waves: n times the variance of means over n samples, for large n. Over
// blocks of growing side it approaches this limit, for noise of finite reach, as 1 / side.
double long_wave_variance(const RangeSteps& steps, double local_variance) {
  constexpr int kSide = 4;  // [samples]; blocks of 8 would leave a quarter of the differences
  // Standard deviations by which blocks must differ from independent samples: 3e-5 of a Gaussian
  // does.
  constexpr double kDeviations = 4.0;
  const BlockFit large = fit_blocks(coarse_steps(steps, kSide));
  if (!large.positions_rule) return local_variance;
  const double of_large = kSide * kSide * large.fit.position_variance;
  const double deviation = std::sqrt(2.0 / static_cast<double>(large.differences));
  if (of_large < (1.0 + kDeviations * deviation) * local_variance) return local_variance;
  const BlockFit small = fit_blocks(coarse_steps(steps, kSide / 2));
  const double of_small = 0.25 * kSide * kSide * small.fit.position_variance;
  return std::max(of_large, 2.0 * of_large - of_small);
}

// Excess over the noise of robust variances, both for values in units of what is sought.
struct Excess {
  std::vector<double> values, noise;
};

struct ExcessVariance {
  double value = 0.0, standard_error = 0.0;
};

// For values of which about one in `overlap` is independent.
ExcessVariance variance_of(Excess&& excess, double overlap) {
  const double independent = static_cast<double>(excess.values.size()) / overlap;
  const double total = core_sigma(std::move(excess.values));
  const double random = median(excess.noise);
  return {std::max(0.0, total * total - random * random),
          total * total * std::sqrt(2.0 / independent)};
}

// Equation (H9): over k edges the discrepancy has variance 2 sigma_position^2 + nodes
// sigma_normal^2 + (sum of sensitivities)^2 bias^2.
double smooth_bias(const RangeSteps& steps, const WalkFit& noise) {
  constexpr int kLength = 16;  // [edges]
  Excess excess;
  for_each_walk(steps, kLength, std::max(2, thinning(steps)),
                [&](const auto& direction, int u, int v, int du, int dv) {
                  const WalkSums sums = walk(direction, u, v, du, dv, kLength);
                  if (!(sums.sensitivity > 0.0)) return;
                  excess.values.push_back(sums.discrepancy / sums.sensitivity);
                  excess.noise.push_back(std::sqrt(2.0 * noise.position_variance +
                                                   sums.node_squares * noise.normal_variance) /
                                         sums.sensitivity);
                });
  return std::sqrt(variance_of(std::move(excess), 1.0).value);
}

// The change of the bias from pixel to pixel, from what second differences over long walks have in
// excess of the noise, equation (H8). Lengths that show it best count most.
double bias_gradient(const RangeSteps& steps, const WalkFit& noise) {
  constexpr std::array<int, 4> kLengths{8, 16, 32, 64};  // [edges]
  std::array<ExcessVariance, kLengths.size()> by_length;
  each(kLengths, [&](std::size_t n, int k) {
    Excess excess;
    const auto visit = [&](const auto& direction, int u, int v, int du, int dv) {
      const SecondDifference d = second_difference(direction, u, v, du, dv, k);
      if (!(d.value == d.value)) return;
      excess.values.push_back(d.value / d.area);
      excess.noise.push_back(
          std::sqrt(6.0 * noise.position_variance + d.nodes * noise.normal_variance) / d.area);
    };
    for_each_walk(steps, 2 * k, std::max({k / 4, 2, thinning(steps)}), visit);
    if (excess.values.size() >= 30) by_length[n] = variance_of(std::move(excess), 16.0);
  });
  double sum = 0.0, weights = 0.0;
  for (const ExcessVariance& variance : by_length) {
    const double weight = 1.0 / std::pow(variance.standard_error, 2);
    if (!std::isfinite(weight)) continue;
    sum += weight * variance.value;
    weights += weight;
  }
  return weights > 0.0 ? std::sqrt(sum / weights) : 0.0;
}

}  // namespace

NoiseEstimate estimate_noise(const RangeSteps& steps) {
  NoiseEstimate estimate;
  const std::vector<SecondDifference> differences = second_differences(steps);
  estimate.samples = differences.size();
  if (!estimate.enough()) return estimate;
  estimate.sigma_normal = normal_noise(steps);
  const WalkFit fit =
      fit_second_differences(differences, estimate.sigma_normal * estimate.sigma_normal);
  estimate.sigma_local = std::sqrt(fit.position_variance);
  estimate.sigma_position = std::sqrt(long_wave_variance(steps, fit.position_variance));
  estimate.bias_gradient = bias_gradient(steps, fit);
  estimate.bias = smooth_bias(steps, fit);
  return estimate;
}

NoiseEstimate estimate_noise(const RangeView& view, const GridEdges& edges) {
  return estimate_noise(range_steps(view, edges));
}

}  // namespace relief::hybrid
