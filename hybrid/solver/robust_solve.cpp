#include "hybrid/solver/robust_solve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "hybrid/noise/constraint_median.h"
#include "hybrid/noise/range_deviation.h"
#include "hybrid/solver/bias_roughness.h"
#include "hybrid/solver/view_solver.h"
#include "scan/base/median.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

// A weak prior of the normals' bias [rad], for islands too small to show one. 20 degrees: the
// panel's 7.5 RMS (docs/results.md, Refinement) cost 0.14 a sample; with half of it 0.56.
constexpr double kBiasSize = 0.35;

// Whitened residuals beyond this many standard deviations lose most of their weight. It costs 1
// to 2 % on Gaussian noise (docs/results.md, How close to the least error possible).
constexpr double kRobustWidth = 3.0;

// `roughness` of the bias at each movable sample; empty: the same everywhere.
ViewWeights initial_weights(const ViewProblem& problem, const NoiseModel& noise,
                            const RefineOptions& options, const std::vector<float>& roughness) {
  ViewWeights weights;
  weights.position.assign(problem.grid.size(), 0.0f);
  const double position = 1.0 / (noise.sigma_position * noise.sigma_position);
  for_each_sample(problem, [&](Eigen::Index k, std::uint32_t pixel) {
    weights.position[pixel] = static_cast<float>(position * problem.confidence[k]);
  });
  const bool equal_slopes = options.lambda.has_value();
  for (auto& plane : weights.slope) plane.assign(problem.grid.size(), 0.0f);
  problem.slopes.parallel_for_each([&](int axis, std::size_t i) {
    const auto a = static_cast<std::size_t>(axis);
    const double length =
        equal_slopes ? noise.spacing : 2.0 * problem.slopes.axes[a].half_length[i];
    const double sigma = length * noise.sigma_normal;
    const double truncation =
        equal_slopes ? 0.0 : problem.slopes.truncation_variance(axis, i, noise.sigma_normal);
    weights.slope[a][i] =
        static_cast<float>(1.0 / (noise.slope_share * sigma * sigma + truncation));
  });
  weights.bias_step.assign(problem.grid.size(), 0.0f);
  for_each_sample(problem, [&](Eigen::Index k, std::uint32_t pixel) {
    const double rough = roughness.empty() ? 1.0 : roughness[static_cast<std::size_t>(k)];
    weights.bias_step[pixel] = static_cast<float>(1.0 / (noise.sigma_bias_step * std::sqrt(rough)));
  });
  weights.bias_size = static_cast<float>(1.0 / (kBiasSize * kBiasSize));
  return weights;
}

// The weights of Cauchy's loss, which takes the power from wild normals but never silences the
// normals of fine detail for good. Its width starts at what the residuals are and ends at
// what they should be, so that a first solve misled by many outliers does not reject the truth.
ViewWeights reweighted(const ViewProblem& problem, ViewWeights weights,
                       std::array<std::vector<float>, 2> residuals) {
  constexpr std::size_t kAtOnce = 1 << 16;  // Pixels of one piece of work; changes no result.
  const auto each = [&](const auto& body) {
    for (const std::size_t axis : {0, 1})
      parallel_for(problem.grid.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(axis, i);
      });
  };
  each([&](std::size_t axis, std::size_t i) {
    residuals[axis][i] = std::abs(residuals[axis][i]) * std::sqrt(weights.slope[axis][i]);
  });
  const double median = median_over_constraints(
      problem, [&](std::size_t axis, std::size_t i) { return residuals[axis][i]; });
  const float scale = static_cast<float>(kSigmaPerMedian) * static_cast<float>(median);
  const float width = static_cast<float>(kRobustWidth) * std::max(1.0f, scale);
  each([&](std::size_t axis, std::size_t i) {
    const float ratio = residuals[axis][i] / width;
    weights.slope[axis][i] /= 1.0f + ratio * ratio;
  });
  return weights;
}

// Reweighting ends when the samples move by less than this part of their noise. Refining leaves
// 0.02 of it or more (docs/results.md, Against the published method): that adds 3 % in quadrature.
constexpr double kSettled = 0.005;

// Rounds whose weights are about to change need no precise solution.
double rough_tolerance(const RefineOptions& options) { return std::max(options.tolerance, 5e-3); }

}  // namespace

RobustSolve solve_robustly(const ViewProblem& problem, const NoiseModel& noise,
                           const RefineOptions& options, const Context& context) {
  const bool with_bias = options.bias == BiasModel::kLatent;
  const auto solver = make_view_solver(problem, with_bias, options.solver);
  std::vector<float> roughness;
  ViewWeights weights = initial_weights(problem, noise, options, roughness);
  RobustSolve result;
  const auto count = static_cast<Eigen::Index>(problem.size());
  result.y = Eigen::VectorXd::Zero((with_bias ? 3 : 1) * count);
  const auto solve_to = [&](double tolerance) {
    const LinearSolve solve = solver->minimise(result.y, tolerance, options.max_iterations);
    result.iterations += solve.iterations;
    if (!solve.converged) result.status = RefineStatus::kNotConverged;
    return solve.converged;
  };
  for (bool last = false; !last; ++result.rounds) {
    if (!report_progress(context.progress, double(result.rounds) / (options.robust_rounds + 1),
                         "refine")) {
      result.interrupted = true;
      return result;
    }
    // The first solution tells where the bias is rough. Later ones would find it ever rougher
    // there.
    if (result.rounds == 1 && !options.sigma_bias_step)
      roughness = bias_roughness(problem, result.y);
    if (result.rounds > 0)
      weights = reweighted(problem, initial_weights(problem, noise, options, roughness),
                           slope_residuals(problem, result.y));
    if (!solver->set_weights(weights)) {
      result.status = RefineStatus::kSolverFailed;
      return result;
    }
    last = result.rounds == options.robust_rounds;
    const Eigen::VectorXd before = result.y.head(count);
    if (!solve_to(last ? options.tolerance : rough_tolerance(options))) return result;
    if (!last && (result.y.head(count) - before).norm() <
                     kSettled * noise.sigma_position * std::sqrt(static_cast<double>(count))) {
      last = true;
      if (!solve_to(options.tolerance)) return result;
    }
  }
  if (options.deviation) {
    DeviationOptions deviation;
    deviation.crossover = noise.crossover();
    deviation.max_iterations = options.max_iterations;
    deviation.seed = context.seed;
    result.deviation =
        range_deviation(problem, weights, noise.measured, result.y, *solver, deviation);
  }
  return result;
}

}  // namespace relief::hybrid
