#include "hybrid/noise/range_deviation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "hybrid/noise/surface_average.h"
#include "scan/base/counter_random.h"

namespace relief::hybrid {

namespace {

// Part of the crossover length over which deviations are averaged. They scatter by 8 % with it
// (docs/results.md, Range standard deviations); by twice as much with half, a quarter of the area.
constexpr double kWindow = 0.7;

// At a straight border half of the surroundings are missing and the variance is about three times
// that inside, two of them because there is half as much to average, the rest for want of anything
// that holds the slope.
Eigen::ArrayXf at_border(const Eigen::ArrayXf& share) { return 1.0f / (share * share.sqrt()); }

// Errors of unit variance at one pixel. Only second moments matter: signs do for normal numbers.
class PixelErrors {
 public:
  PixelErrors(const CounterRandom& random, std::size_t pixel) : bits_(random.bits(pixel)) {}
  double range() const { return sign(0); }
  double slope(int axis) const { return sign(1 + axis); }
  double truncation(int axis) const { return sign(3 + axis); }

 private:
  double sign(int bit) const { return (bits_ >> bit & 1) != 0 ? 1.0 : -1.0; }
  std::uint64_t bits_;
};

// What the right sides of (H10) and (H11) are made from.
struct ErrorSystem {
  const ViewProblem& problem;
  const ViewWeights& weights;
  std::vector<std::uint32_t> number;  // of movable samples, by padded index
  bool with_bias;

  Eigen::Index count() const { return static_cast<Eigen::Index>(problem.size()); }
  Eigen::VectorXd zero() const { return Eigen::VectorXd::Zero((with_bias ? 3 : 1) * count()); }
};

// The right side of (H10) for one set of errors.
Eigen::VectorXd perturbation(const ErrorSystem& system, const MeasurementNoise& noise,
                             const CounterRandom& random) {
  const ViewProblem& problem = system.problem;
  Eigen::VectorXd rhs = system.zero();
  for_each_sample(problem, [&](Eigen::Index k, std::uint32_t pixel) {
    const double confidence = problem.confidence[k];
    if (!(confidence > 0.0)) return;
    const double sigma = noise.sigma_position / std::sqrt(confidence);
    rhs[k] = system.weights.position[pixel] * sigma * PixelErrors(random, pixel).range();
  });
  problem.slopes.parallel_for_each([&](int axis, std::size_t i) {
    const auto a = static_cast<std::size_t>(axis);
    const SlopeConstraints::Axis& plane = problem.slopes.axes[a];
    const SlopeConstraints::Ends ends = problem.slopes.ends(axis, i);
    const double half_length = plane.half_length[i];
    const PixelErrors here(random, i), at0(random, ends.at0), at1(random, ends.at1);
    const double error =
        half_length * noise.sigma_normal * (at0.slope(axis) + at1.slope(axis)) +
        std::sqrt(problem.slopes.truncation_variance(axis, i, noise.sigma_normal)) *
            here.truncation(axis);
    const double weighted = system.weights.slope[a][i] * error;
    rhs[system.number[ends.tail]] += weighted * plane.tail_slope[i];
    rhs[system.number[ends.head]] -= weighted * plane.head_slope[i];
    if (!system.with_bias) return;
    for (const std::size_t at : {ends.at0, ends.at1})
      rhs[(1 + axis) * system.count() + system.number[at]] += weighted * half_length;
  });
  return rhs;
}

// The right side of (H11): what the prior of the bias takes from the bias in `y`.
Eigen::VectorXd shrinkage(const ErrorSystem& system, const Eigen::VectorXd& y) {
  const Eigen::Index count = system.count();
  Eigen::VectorXd rhs = system.zero();
  rhs.tail(2 * count) = double{system.weights.bias_size} * y.tail(2 * count);
  for_each_bias_pair(system.problem, [&](std::size_t at0, std::size_t at1) {
    for (const Eigen::Index block : {count, 2 * count}) {
      const Eigen::Index a = block + system.number[at0], b = block + system.number[at1];
      const double change = system.weights.bias_step_between(at0, at1) * (y[a] - y[b]);
      rhs[a] += change;
      rhs[b] -= change;
    }
  });
  return rhs;
}

// About how many times larger variances are near borders than inside. Every octave of wavelengths
// up to the crossover contributes alike to the variance, and feels a border within its own length.
Eigen::ArrayXf border_factor(const SurfaceAverage& surface, Eigen::Index count, double crossover) {
  Eigen::ArrayXf sum = Eigen::ArrayXf::Zero(count);
  int octaves = 0;
  for (double length = crossover; length > 0.5; length *= 0.5, ++octaves)
    sum += at_border(surface.share(length).array());
  return sum / static_cast<float>(octaves);
}

// A few probes are noisy at each sample, but what they vary about changes slowly along the surface
// once its rise towards borders is divided out. The bias itself is found too flat near borders, so
// what it leaves in the range rises there once more, at most as at a corner: a surface that is
// small against the crossover would have no bound.
Eigen::VectorXf smoothed(const ViewProblem& problem, const Eigen::VectorXf& from_noise,
                         const Eigen::VectorXf& from_bias, double crossover) {
  const int largest = std::max(problem.grid.width, problem.grid.height);
  crossover = std::clamp(crossover, 1.0, static_cast<double>(largest));
  const SurfaceAverage surface(problem, crossover);
  const Eigen::ArrayXf factor = border_factor(surface, from_noise.size(), crossover);
  const Eigen::ArrayXf rise = factor.min(at_border(Eigen::ArrayXf::Constant(1, 0.25f))[0]);
  const Eigen::VectorXf level = (from_noise.array() + rise * from_bias.array()) / factor;
  return surface.average(level, kWindow * crossover).array() * factor;
}

// No more than the sample's own range leaves: with a few samples between borders the factor, which
// is for surfaces, has no bound.
void limit_to_measured(const ViewProblem& problem, const MeasurementNoise& noise,
                       Eigen::VectorXf& variance) {
  const double of_one = noise.sigma_position * noise.sigma_position;
  for_each_sample(problem, [&](Eigen::Index k, std::uint32_t) {
    const double confidence = problem.confidence[k];
    if (confidence > 0.0)
      variance[k] = std::min(variance[k], static_cast<float>(of_one / confidence));
  });
}

}  // namespace

Eigen::VectorXf range_deviation(const ViewProblem& problem, const ViewWeights& weights,
                                const MeasurementNoise& noise, const Eigen::VectorXd& y,
                                ViewSolver& solver, const DeviationOptions& options) {
  const bool with_bias = y.size() > static_cast<Eigen::Index>(problem.size());
  const ErrorSystem system{problem, weights, numbers_of(problem), with_bias};
  Eigen::VectorXf from_noise = Eigen::VectorXf::Zero(system.count()), from_bias = from_noise;
  const auto add_squared_error = [&](Eigen::VectorXd rhs, Eigen::VectorXf& sum) {
    const bool solved = solver.solve(rhs, options.tolerance, options.max_iterations).converged;
    if (solved) sum += rhs.head(system.count()).cwiseAbs2().cast<float>();
    return solved;
  };
  for (int probe = 0; probe < options.probes; ++probe) {
    const CounterRandom random(options.seed, static_cast<std::uint64_t>(probe));
    if (!add_squared_error(perturbation(system, noise, random), from_noise)) return {};
  }
  from_noise /= static_cast<float>(options.probes);
  if (with_bias && !add_squared_error(shrinkage(system, y), from_bias)) return {};
  if (!(options.crossover > 0.0)) return (from_noise + from_bias).cwiseSqrt();
  Eigen::VectorXf variance = smoothed(problem, from_noise, from_bias, options.crossover);
  limit_to_measured(problem, noise, variance);
  return variance.cwiseSqrt();
}

}  // namespace relief::hybrid
