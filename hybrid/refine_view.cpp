#include "hybrid/refine_view.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "hybrid/contradicted_normals.h"
#include "hybrid/normal_correction.h"
#include "hybrid/normal_screening.h"
#include "hybrid/range_deviation.h"
#include "hybrid/unexplained_steps.h"
#include "hybrid/view_problem.h"
#include "hybrid/view_solver.h"
#include "scan/median.h"
#include "scan/parallel.h"

namespace relief {

namespace {

// A bias of the normals is an angle: this weak prior [rad] only keeps it determined on islands too
// small to show one.
constexpr double kBiasSize = 0.35;

// Whitened residuals beyond this many standard deviations lose most of their weight.
constexpr double kRobustWidth = 3.0;

// Noise of a view in the form that the weights need.
struct NoiseModel {
  double sigma_position = 0.0;
  double sigma_normal = 0.0;
  double sigma_bias_step = 0.0;
  double spacing = 0.0;
  double slope_share = 1.0;   // variance of a slope constraint, in (length sigma_normal)^2
  MeasurementNoise measured;  // what the measurements are like, whatever they are weighted by
};

// A pair of neighbouring normals, averaged, errs by cos(w / 2) times what one does at the frequency
// w [rad per sample]: all of it over long waves, half of the variance on average. What counts is
// where positions and normals cross; normals that rule at all frequencies share no more than half.
double share_of_averaged_normals(const NoiseModel& noise) {
  const double crossover = noise.spacing * noise.sigma_normal / noise.sigma_position;
  return std::max(0.5, std::pow(std::cos(0.5 * std::min(std::numbers::pi, crossover)), 2));
}

// Every so many-th of `count` values such that a median of them is good to about a percent.
std::size_t thinning(std::size_t count) { return std::max<std::size_t>(1, count / 100000); }

double median_length(const ViewProblem& problem) {
  std::vector<float> lengths;
  const std::size_t stride = thinning(problem.constraints);
  std::size_t k = 0;
  problem.slopes.for_each([&](int axis, std::size_t i) {
    if (k++ % stride == 0)
      lengths.push_back(2.0f * problem.slopes.axes[static_cast<std::size_t>(axis)].half_length[i]);
  });
  return median(std::move(lengths));
}

// The random walk whose power sigma_b^2 / frequency^2 best explains a bias of RMS change
// `gradient`: the squared changes are shared among the frequencies at which the bias exceeds the
// other errors,
//   sigma_b^2 = gradient^2 / (share of those frequencies),
// found by iteration. At least the walk that meets the noise of the normals where they and the
// positions cross: a larger one costs little, a smaller one leaves bias in the range.
double default_bias_step(const NoiseModel& noise, double gradient) {
  const double position = noise.sigma_position / noise.spacing;
  const double crossover = std::min(1.0, noise.sigma_normal / position);  // [rad per sample]
  double sigma = noise.sigma_normal * crossover;
  const double least = sigma;
  for (int round = 0; round < 30; ++round) {
    const double normal = noise.sigma_normal * noise.sigma_normal;
    // sigma^2 / w^2 = normal + w^2 position^2, a quadratic in w^2
    const double squared_frequency =
        2.0 * sigma * sigma /
        (normal + std::sqrt(normal * normal + 4.0 * position * position * sigma * sigma));
    const double share = std::min(1.0, squared_frequency / (4.0 * std::numbers::pi));
    sigma = std::max(least, std::numbers::sqrt2 * gradient / std::sqrt(share));
  }
  return sigma;
}

NoiseModel noise_model(const RefineOptions& options, const NoiseEstimate& estimate, double spacing,
                       std::size_t samples) {
  NoiseModel noise;
  noise.spacing = spacing;
  noise.sigma_position = options.sigma_position.value_or(estimate.sigma_position);
  noise.sigma_normal = options.sigma_normal.value_or(estimate.sigma_normal);
  // Normals that rule over more samples than there are could as well be that much less precise.
  if (!options.sigma_normal && estimate.enough())
    noise.sigma_normal =
        std::max(noise.sigma_normal,
                 noise.sigma_position / (spacing * std::sqrt(static_cast<double>(samples))));
  // E_p / sigma_p^2 + E_n / (l sigma_n)^2 is the published sum up to a factor.
  if (options.lambda)
    noise.sigma_normal =
        noise.sigma_position / noise.spacing * std::sqrt(*options.lambda / (1.0 - *options.lambda));
  else if (options.stencil == Stencil::kCompactEdge)
    noise.slope_share = share_of_averaged_normals(noise);
  noise.sigma_bias_step =
      options.sigma_bias_step.value_or(default_bias_step(noise, estimate.bias_gradient));
  noise.measured = {noise.sigma_position, noise.sigma_normal};
  if (options.lambda && estimate.sigma_normal > 0.0)
    noise.measured.sigma_normal = estimate.sigma_normal;
  return noise;
}

double equivalent_lambda(const NoiseModel& noise) {
  const double step = noise.spacing * noise.sigma_normal;
  const double variance = noise.slope_share * step * step;
  return variance / (noise.sigma_position * noise.sigma_position + variance);
}

ViewWeights initial_weights(const ViewProblem& problem, const NoiseModel& noise,
                            bool equal_slopes) {
  ViewWeights weights;
  weights.position.assign(problem.grid.size(), 0.0f);
  const double position = 1.0 / (noise.sigma_position * noise.sigma_position);
  for (std::size_t k = 0; k < problem.size(); ++k)
    weights.position[problem.pixels[k]] =
        static_cast<float>(position * problem.confidence[static_cast<Eigen::Index>(k)]);
  for (auto& plane : weights.slope) plane.assign(problem.grid.size(), 0.0f);
  problem.slopes.for_each([&](int axis, std::size_t i) {
    const auto a = static_cast<std::size_t>(axis);
    const double length =
        equal_slopes ? noise.spacing : 2.0 * problem.slopes.axes[a].half_length[i];
    const double sigma = length * noise.sigma_normal;
    weights.slope[a][i] = static_cast<float>(1.0 / (noise.slope_share * sigma * sigma));
  });
  weights.bias_step = static_cast<float>(1.0 / (noise.sigma_bias_step * noise.sigma_bias_step));
  weights.bias_size = static_cast<float>(1.0 / (kBiasSize * kBiasSize));
  return weights;
}

// The weights of Cauchy's loss, which takes the power from wild normals but never silences the
// normals of fine detail for good. Its width starts at what the residuals are and ends at
// what they should be, so that a first solve misled by many outliers does not reject the truth.
ViewWeights reweighted(const ViewProblem& problem, const ViewWeights& plain,
                       std::array<std::vector<float>, 2> residuals, int threads) {
  constexpr std::size_t kAtOnce = 1 << 16;
  const auto each = [&](const auto& body) {
    for (const std::size_t axis : {0, 1})
      parallel_for(problem.grid.size(), kAtOnce, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(axis, i);
      });
  };
  each([&](std::size_t axis, std::size_t i) {
    residuals[axis][i] = std::abs(residuals[axis][i]) * std::sqrt(plain.slope[axis][i]);
  });
  std::vector<float> whitened;
  const std::size_t stride = thinning(problem.constraints);
  std::size_t k = 0;
  problem.slopes.for_each([&](int axis, std::size_t i) {
    if (k++ % stride == 0) whitened.push_back(residuals[static_cast<std::size_t>(axis)][i]);
  });
  const float scale = 1.4826f * static_cast<float>(median(std::move(whitened)));
  const float width = static_cast<float>(kRobustWidth) * std::max(1.0f, scale);
  ViewWeights weights = plain;
  each([&](std::size_t axis, std::size_t i) {
    const float ratio = residuals[axis][i] / width;
    weights.slope[axis][i] /= 1.0f + ratio * ratio;
  });
  return weights;
}

RangeView without(const RangeView& view, const Grid<std::uint8_t>& isolated) {
  RangeView rest = view;
  for (std::size_t i = 0; i < rest.normals.size(); ++i)
    if (isolated[i]) rest.normals[i].setConstant(static_cast<float>(kNoSample));
  return rest;
}

// Reweighting ends when the samples move by less than this part of their noise.
constexpr double kSettled = 0.005;

// Rounds whose weights are about to change need no precise solution.
double rough_tolerance(const RefineOptions& options) { return std::max(options.tolerance, 1e-3); }

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

struct RobustSolve {
  Eigen::VectorXd y;
  Eigen::VectorXf deviation;  // of y's ranges; empty when not found
  RefineStatus status = RefineStatus::kRefined;
  int rounds = 0, iterations = 0;
  bool interrupted = false;
};

RobustSolve solve_robustly(const ViewProblem& problem, const NoiseModel& noise,
                           const RefineOptions& options, const Progress& progress) {
  const bool with_bias = options.bias == BiasModel::kLatent;
  const auto solver = make_view_solver(problem, with_bias, options.solver, options.threads);
  const ViewWeights plain = initial_weights(problem, noise, options.lambda.has_value());
  ViewWeights weights = plain;
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
    if (!report_progress(progress, double(result.rounds) / (options.robust_rounds + 1), "refine")) {
      result.interrupted = true;
      return result;
    }
    if (result.rounds > 0)
      weights = reweighted(problem, plain, slope_residuals(problem, result.y, options.threads),
                           options.threads);
    if (!solver->set_weights(weights)) {
      result.status = RefineStatus::kSolverFailed;
      return result;
    }
    last = result.rounds == options.robust_rounds;
    const Eigen::VectorXd before = result.y.head(count);
    if (!solve_to(last ? options.tolerance : rough_tolerance(options))) return result;
    if (!last && rms(result.y.head(count) - before) < kSettled * noise.sigma_position) {
      last = true;
      if (!solve_to(options.tolerance)) return result;
    }
  }
  if (options.deviation) {
    DeviationOptions deviation;
    deviation.crossover = noise.sigma_position / (noise.spacing * noise.sigma_normal);
    deviation.max_iterations = options.max_iterations;
    deviation.threads = options.threads;
    result.deviation =
        range_deviation(problem, weights, noise.measured, result.y, *solver, deviation);
  }
  return result;
}

// Samples that stay as measured have the deviation of their measurement.
Grid<float> deviations(const RangeView& view, const ViewProblem& problem, double sigma_position,
                       const Eigen::VectorXf& refined) {
  Grid<float> deviation(view.width(), view.height(), static_cast<float>(kNoSample));
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      const double confidence = view.confidence_at(u, v);
      if (view.has_sample(u, v) && confidence > 0.0)
        deviation(u, v) = static_cast<float>(sigma_position / std::sqrt(confidence));
    }
  }
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const std::uint32_t i = problem.pixels[k];
    deviation(problem.grid.u(i), problem.grid.v(i)) = refined[static_cast<Eigen::Index>(k)];
  }
  return deviation;
}

void move_samples(const ViewProblem& problem, const Eigen::VectorXd& y, RangeView& view) {
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const int u = problem.grid.u(problem.pixels[k]), v = problem.grid.v(problem.pixels[k]);
    view.range(u, v) += y[static_cast<Eigen::Index>(k)] / view.camera.ray(u, v).direction.norm();
  }
}

Result<void> validate(const RefineOptions& options) {
  const auto positive = [](const std::optional<double>& value) {
    return !value || (*value > 0.0 && std::isfinite(*value));
  };
  const auto bad = [](const std::string& field, const std::string& constraint) {
    return Error{ErrorKind::kBadInput, "refine: " + field + " must be " + constraint};
  };
  if (!positive(options.sigma_position)) return bad("sigma_position", "positive");
  if (!positive(options.sigma_normal)) return bad("sigma_normal", "positive");
  if (!positive(options.sigma_bias_step)) return bad("sigma_bias_step", "positive");
  if (!positive(options.smoothing_scale)) return bad("smoothing_scale", "positive");
  if (options.lambda && !(*options.lambda > 0.0 && *options.lambda < 1.0))
    return bad("lambda", "between 0 and 1, both excluded");
  if (options.lambda && options.sigma_normal)
    return bad("lambda", "absent when sigma_normal is given: it stands in its place");
  if (options.robust_rounds < 0) return bad("robust_rounds", "at least 0");
  if (!(options.tolerance > 0.0)) return bad("tolerance", "positive");
  if (options.max_iterations < 1) return bad("max_iterations", "at least 1");
  return {};
}

// The steps of refine_view, each of which may end it early.
class Refinement {
 public:
  Refinement(const RangeView& view, const RefineOptions& options) : options_(options) {
    result_.view = view;
    result_.kept = view.sample_count();
  }

  // Whether there is something to solve; if not, the status says why.
  bool prepare() {
    RangeView& view = result_.view;
    edges_ = connect_samples(view, options_.discontinuities);
    const RangeSteps steps = screen(view);
    NoiseEstimate estimate = estimate_noise(steps);
    if (options_.sigma_position)
      estimate.sigma_position = estimate.sigma_local = *options_.sigma_position;
    if (options_.sigma_normal) estimate.sigma_normal = *options_.sigma_normal;
    if (estimate.sigma_local > 0.0)
      edges_ = cut_unexplained_steps(edges_, steps, estimate, options_.threads);
    problem_ = make_view_problem(view, edges_, options_.stencil, options_.threads);
    if (problem_.empty()) return stop(why_empty());
    noise_ = noise_model(options_, estimate, median_length(problem_), problem_.size());
    if (!(noise_.sigma_position > 0.0) || !(noise_.sigma_normal > 0.0))
      return stop(RefineStatus::kNoNoise);
    if (options_.robust_rounds > 0 && options_.stencil == Stencil::kCompactEdge)
      turn_contradicted_normals(estimate);
    return options_.bias != BiasModel::kTwoStep || correct_first();
  }

  // False when interrupted.
  bool solve(const Progress& progress) {
    const RobustSolve solved = solve_robustly(problem_, noise_, options_, progress);
    if (solved.interrupted) return false;
    result_.status = solved.status;
    result_.rounds = solved.rounds;
    result_.iterations = solved.iterations;
    if (solved.status != RefineStatus::kSolverFailed) finish(solved);
    return true;
  }

  RefinedView& result() { return result_; }

 private:
  bool stop(RefineStatus status) {
    result_.status = status;
    return false;
  }

  // Replaces wild normals, and measures the steps without them.
  RangeSteps screen(RangeView& view) {
    if (options_.robust_rounds == 0) return range_steps(view, edges_, options_.threads);
    ScreenedNormals screened = screen_normals(view, options_.threads);
    const RangeSteps steps =
        range_steps(without(view, screened.isolated), edges_, options_.threads);
    view.normals = std::move(screened.normals);
    result_.replaced_normals = screened.count;
    return steps;
  }

  void turn_contradicted_normals(const NoiseEstimate& estimate) {
    const CoherentErrors errors = coherent_errors(problem_, estimate, noise_.spacing);
    if (errors.samples == 0) return;
    result_.turned_normals = errors.samples;
    result_.view.normals = subtract_bias(result_.view, problem_, errors.slopes);
    problem_ = make_view_problem(result_.view, edges_, options_.stencil, options_.threads);
  }

  RefineStatus why_empty() const {
    const bool unconstrained = slope_constraints(result_.view, edges_, options_.stencil).empty();
    return unconstrained ? RefineStatus::kNoNormals : RefineStatus::kNoConfidence;
  }

  bool correct_first() {
    const double scale = options_.smoothing_scale.value_or(noise_.sigma_position /
                                                           (noise_.spacing * noise_.sigma_normal));
    TwoStepResult corrected = two_step_correction(result_.view, edges_, problem_, scale);
    if (!corrected.solved) return stop(RefineStatus::kSolverFailed);
    result_.view.normals = std::move(corrected.normals);
    problem_ = make_view_problem(result_.view, edges_, options_.stencil, options_.threads);
    return true;
  }

  void finish(const RobustSolve& solved) {
    const Eigen::VectorXd& y = solved.y;
    const auto count = static_cast<Eigen::Index>(problem_.size());
    move_samples(problem_, y, result_.view);
    if (y.size() > count) {
      const Eigen::VectorXd bias = y.tail(2 * count);
      result_.view.normals = subtract_bias(result_.view, problem_, bias);
      result_.bias_rms = rms(bias);
    }
    result_.view.deviation = {};
    if (solved.deviation.size() > 0)
      result_.view.deviation =
          deviations(result_.view, problem_, noise_.sigma_position, solved.deviation);
    result_.rms_change = rms(y.head(count));
    result_.refined = problem_.size();
    result_.kept = problem_.pinned;
    result_.sigma_position = noise_.sigma_position;
    result_.sigma_normal = noise_.sigma_normal;
    result_.lambda = equivalent_lambda(noise_);
  }

  RefineOptions options_;
  RefinedView result_;
  GridEdges edges_;
  ViewProblem problem_;
  NoiseModel noise_;
};

}  // namespace

std::string_view to_string(RefineStatus status) {
  switch (status) {
    case RefineStatus::kRefined:
      return "refined";
    case RefineStatus::kNoNormals:
      return "no normals";
    case RefineStatus::kNoConfidence:
      return "no confidence";
    case RefineStatus::kNoNoise:
      return "noise unknown";
    case RefineStatus::kNotConverged:
      return "not converged";
    case RefineStatus::kSolverFailed:
      return "solver failed";
  }
  return "";
}

Result<RefinedView> refine_view(const RangeView& view, const RefineOptions& options,
                                const Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  if (const Result<void> valid = validate(options); !valid) return valid.error();
  Refinement refinement(view, options);
  if (refinement.prepare() && !refinement.solve(progress))
    return Error{ErrorKind::kInterrupted, "refine: stopped on request"};
  RefinedView& result = refinement.result();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return std::move(result);
}

}  // namespace relief
