#include "hybrid/range_deviation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "hybrid/surface_average.h"
#include "scan/counter_random.h"

namespace relief {

namespace {

// Deviations are averaged over this part of the crossover length.
constexpr double kWindow = 0.7;

// At a straight border half of the surroundings are missing and the variance is about three times
// that inside, two of them because there is half as much to average, the rest for want of anything
// that holds the slope.
constexpr double kBorderPower = 1.5;

// Errors of unit variance at one pixel. Only second moments matter: signs do for normal numbers.
class PixelErrors {
 public:
  PixelErrors(const CounterRandom& random, std::size_t pixel) : bits_(random.bits(pixel)) {}
  double range() const { return sign(0); }
  double slope(int axis) const { return sign(1 + axis); }

 private:
  double sign(int bit) const { return (bits_ >> bit & 1) != 0 ? 1.0 : -1.0; }
  std::uint64_t bits_;
};

// The right side of (13) for one set of errors.
Eigen::VectorXd perturbation(const ViewProblem& problem, const ViewWeights& weights,
                             const MeasurementNoise& noise, bool with_bias,
                             const std::vector<std::uint32_t>& number,
                             const CounterRandom& random) {
  const auto count = static_cast<Eigen::Index>(problem.size());
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero((with_bias ? 3 : 1) * count);
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const std::uint32_t pixel = problem.pixels[k];
    if (!(problem.confidence[i] > 0.0f)) continue;
    const double sigma = noise.sigma_position / std::sqrt(double{problem.confidence[i]});
    rhs[i] = weights.position[pixel] * sigma * PixelErrors(random, pixel).range();
  }
  problem.slopes.for_each([&](int axis, std::size_t i) {
    const auto a = static_cast<std::size_t>(axis);
    const SlopeConstraints::Axis& plane = problem.slopes.axes[a];
    const SlopeConstraints::Ends ends = problem.slopes.ends(axis, i);
    const double half_length = plane.half_length[i];
    const double slopes =
        PixelErrors(random, ends.at0).slope(axis) + PixelErrors(random, ends.at1).slope(axis);
    const double weighted = weights.slope[a][i] * half_length * noise.sigma_normal * slopes;
    rhs[number[ends.tail]] += weighted * plane.tail_slope[i];
    rhs[number[ends.head]] -= weighted * plane.head_slope[i];
    if (!with_bias) return;
    for (const std::size_t at : {ends.at0, ends.at1})
      rhs[(1 + axis) * count + number[at]] += weighted * half_length;
  });
  return rhs;
}

// The right side of (14): what the prior of the bias takes from the bias in `y`.
Eigen::VectorXd shrinkage(const ViewProblem& problem, const ViewWeights& weights,
                          const Eigen::VectorXd& y) {
  const auto count = static_cast<Eigen::Index>(problem.size());
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(y.size());
  const auto neighbours = bias_neighbours(problem);
  for (const Eigen::Index block : {count, 2 * count}) {
    for (const auto& [a, b] : neighbours) {
      const double change = weights.bias_step * (y[block + a] - y[block + b]);
      rhs[block + a] += change;
      rhs[block + b] -= change;
    }
    rhs.segment(block, count) += weights.bias_size * y.segment(block, count);
  }
  return rhs;
}

// About how many times larger variances are near borders than inside. Every octave of wavelengths
// up to the crossover contributes alike to the variance, and feels a border within its own length.
Eigen::ArrayXd border_factor(const SurfaceAverage& surface, Eigen::Index count, double crossover) {
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(count);
  int octaves = 0;
  for (double length = crossover; length > 0.5; length *= 0.5, ++octaves)
    sum += surface.share(length).array().pow(-kBorderPower);
  return sum / octaves;
}

// A few probes are noisy at each sample, but what they vary about changes slowly along the surface
// once its rise towards borders is divided out. The bias itself is found too flat near borders, so
// what it leaves in the range rises there once more.
Eigen::VectorXd smoothed(const ViewProblem& problem, const Eigen::VectorXd& from_noise,
                         const Eigen::VectorXd& from_bias, double crossover, int threads) {
  const int largest = std::max(problem.grid.width, problem.grid.height);
  crossover = std::clamp(crossover, 1.0, static_cast<double>(largest));
  const SurfaceAverage surface(problem, threads);
  const Eigen::ArrayXd factor = border_factor(surface, from_noise.size(), crossover);
  const Eigen::VectorXd level = from_noise.array() / factor + from_bias.array();
  return surface.average(level, kWindow * crossover).array() * factor;
}

}  // namespace

Eigen::VectorXf range_deviation(const ViewProblem& problem, const ViewWeights& weights,
                                const MeasurementNoise& noise, const Eigen::VectorXd& y,
                                ViewSolver& solver, const DeviationOptions& options) {
  const auto count = static_cast<Eigen::Index>(problem.size());
  const bool with_bias = y.size() > count;
  const auto squared_error = [&](const Eigen::VectorXd& rhs) -> Eigen::VectorXd {
    Eigen::VectorXd error = Eigen::VectorXd::Zero(rhs.size());
    if (!solver.solve(rhs, error, options.tolerance, options.max_iterations).converged)
      error.setConstant(std::numeric_limits<double>::quiet_NaN());
    return error.head(count).cwiseAbs2();
  };
  const std::vector<std::uint32_t> number = numbers_of(problem);
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(count), from_bias = variance;
  for (int probe = 0; probe < options.probes; ++probe) {
    const CounterRandom random(options.seed, static_cast<std::uint64_t>(probe));
    variance += squared_error(perturbation(problem, weights, noise, with_bias, number, random));
  }
  variance /= options.probes;
  if (with_bias) from_bias = squared_error(shrinkage(problem, weights, y));
  if (!variance.allFinite() || !from_bias.allFinite()) return {};
  if (options.crossover > 0.0)
    variance = smoothed(problem, variance, from_bias, options.crossover, options.threads);
  else
    variance += from_bias;
  return variance.cwiseSqrt().cast<float>();
}

}  // namespace relief
