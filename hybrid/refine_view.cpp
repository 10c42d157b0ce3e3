#include "relief/hybrid/refine_view.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "hybrid/model/prepared_view.h"
#include "hybrid/model/smooth_change.h"
#include "hybrid/model/view_part.h"
#include "hybrid/model/view_problem.h"
#include "hybrid/noise/deviation_spectrum.h"
#include "hybrid/noise/noise_model.h"
#include "hybrid/normals/normal_correction.h"
#include "hybrid/normals/normal_outliers.h"
#include "hybrid/normals/normal_screening.h"
#include "hybrid/normals/unexplained_steps.h"
#include "hybrid/normals/wild_samples.h"
#include "hybrid/solver/robust_solve.h"
#include "scan/base/stopwatch.h"
#include "scan/grid/filled_view.h"

namespace relief::hybrid {

namespace {

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

RangeView without(const RangeView& view, const Grid<std::uint8_t>& isolated) {
  RangeView rest = view;
  for (std::size_t i = 0; i < rest.normals.size(); ++i)
    if (isolated[i]) rest.normals[i].setConstant(static_cast<float>(kNoSample));
  return rest;
}

// Samples that stay as measured have the deviation of their measurement: an infinite one where
// their confidence is zero.
Grid<float> deviations(const RangeView& view, const ViewProblem& problem, double sigma_position,
                       const Eigen::VectorXf& refined) {
  Grid<float> deviation(view.width(), view.height(), static_cast<float>(kNoSample));
  const PositionConfidence confidence_of(view);
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      const double confidence = confidence_of(u, v);
      if (view.has_sample(u, v))
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
  for_each_sample(problem, [&](Eigen::Index k, std::uint32_t pixel) {
    const int u = problem.grid.u(pixel), v = problem.grid.v(pixel);
    view.range(u, v) += y[k] / view.camera.ray(u, v).direction.norm();
  });
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

// Noise that does this many times the harm that it shows from sample to sample is shared, as that
// of rounding is not. Half of it would take rounding for it, twice would miss shared noise.
constexpr double kShared = 3.0;

// The steps of refine_view, each of which may end it early.
class Refinement {
 public:
  Refinement(const RangeView& view, const RefineOptions& options)
      : measured_(view), options_(options) {
    result_.view = view;
    result_.kept = view.sample_count();
    const double known = PositionConfidence(view).nominal_deviation();
    if (!options_.sigma_position && known > 0.0) options_.sigma_position = known;
  }

  // Whether there is something to solve; if not, the status says why.
  bool prepare() {
    ranges_ = prepare_view(measured_, options_.discontinuities);
    edges_ = ranges_.edges;
    const RangeView trusted = screen(ranges_.view);
    const RangeSteps steps = range_steps(trusted, edges_);
    const NoiseEstimate estimate = estimate_errors(trusted, steps);
    RangeView& view = result_.view = std::move(ranges_.view);
    if (estimate.sigma_local > 0.0) cut_steps(trusted, steps, estimate);
    problem_ = make_view_problem(view, edges_, options_.stencil);
    if (problem_.empty()) return stop(why_empty());
    noise_ = make_noise_model(options_, estimate, problem_);
    if (!noise_.usable()) return stop(RefineStatus::kNoiseUnknown);
    if (options_.robust_rounds > 0 && options_.stencil == Stencil::kCompactEdge)
      turn_contradicted_normals(estimate);
    return options_.bias != BiasModel::kTwoStep || correct_first();
  }

  // False when interrupted.
  bool solve(const Context& context) {
    const RobustSolve solved = solve_robustly(problem_, noise_, options_, context);
    if (solved.interrupted) return false;
    result_.status = solved.status;
    result_.rounds = solved.rounds;
    result_.iterations = solved.iterations;
    if (solved.status == RefineStatus::kSolverFailed)
      keep_as_measured(solved.status);
    else if (contradicts(solved.y))
      keep_as_measured(RefineStatus::kContradiction);
    else
      finish(solved);
    return true;
  }

  RefinedView& result() { return result_; }

 private:
  bool stop(RefineStatus status) {
    keep_as_measured(status);
    return false;
  }

  void keep_as_measured(RefineStatus status) {
    result_.view = measured_;
    result_.status = status;
    if (ranges_.noise.known()) result_.sigma_position = ranges_.noise.sigma;
  }

  // The errors that the steps between measured samples show, but no less of the ranges than
  // rounding leaves. Where the noise changes over the view, that of a typical sample.
  NoiseEstimate estimate_errors(const RangeView& trusted, const RangeSteps& steps) {
    const bool all_measured = ranges_.flying + ranges_.filled == 0;
    NoiseEstimate estimate =
        estimate_noise(all_measured ? steps : range_steps(trusted, ranges_.measured_edges));
    const double sigma = ranges_.noise.sigma;
    if (options_.sigma_position) {
      estimate.sigma_position = estimate.sigma_local = *options_.sigma_position;
    } else if (ranges_.noise.rounded() && estimate.sigma_position < kShared * sigma) {
      // Neighbours rounded alike look like shared noise, but their errors have an end.
      estimate.sigma_position = estimate.sigma_local = sigma;
    }
    // What changes from sample to sample tells nothing of errors that neighbours share.
    if (!ranges_.noise.map.empty() && measured_.deviation.empty() && estimate.sigma_local > 0.0 &&
        estimate.sigma_position < kShared * sigma && confirms(steps, ranges_.noise.map))
      count_by_noise(ranges_);
    if (!ranges_.variance.empty() && !ranges_.noise.rounded() && !options_.sigma_position) {
      estimate.sigma_position = sigma * estimate.sigma_position / estimate.sigma_local;
      estimate.sigma_local = sigma;
    }
    if (options_.sigma_normal) estimate.sigma_normal = *options_.sigma_normal;
    return estimate;
  }

  // Whichever edges there are: wild samples have few.
  template <typename Visit>
  void for_wild_samples(const RangeView& trusted, const NoiseEstimate& estimate,
                        const Visit& visit) const {
    const Grid<std::uint8_t> all(trusted.width(), trusted.height(), 1);
    const RangeSteps steps = range_steps(trusted, {all, all});
    const auto wild = range_outliers(steps, estimate, ranges_.variance);
    for (int v = 0; v < wild.height(); ++v)
      for (int u = 0; u < wild.width(); ++u)
        if (wild(u, v)) visit(u, v);
  }

  static bool joined(const GridEdges& edges, int u, int v) {
    return edges.connected(u, v, 1, 0) || edges.connected(u, v, -1, 0) ||
           edges.connected(u, v, 0, 1) || edges.connected(u, v, 0, -1);
  }

  // Samples that are cut off from all around fly, too, and those that normals show to be wrong by
  // themselves: they follow their neighbours and normals.
  void cut_steps(const RangeView& trusted, const RangeSteps& steps, const NoiseEstimate& estimate) {
    const GridEdges all = edges_;
    edges_ = cut_unexplained_steps(all, steps, estimate, ranges_.variance);
    auto flying = flying_samples(result_.view, edges_);
    for_wild_samples(trusted, estimate, [&](int u, int v) {
      if (joined(all, u, v))
        flying(u, v) = 1;
      else
        result_.view.range(u, v) = kNoSample, ++ranges_.flying;
    });
    const auto count = std::count(flying.begin(), flying.end(), std::uint8_t{1});
    if (count == 0) return;
    ranges_.flying += static_cast<std::size_t>(count);
    take_confidence(flying, result_.view);
    for (int v = 0; v < flying.height(); ++v) {
      for (int u = 0; u < flying.width(); ++u) {
        if (flying(u, v) || (flying.contains(u + 1, v) && flying(u + 1, v)))
          edges_.right(u, v) = all.right(u, v);
        if (flying(u, v) || (flying.contains(u, v + 1) && flying(u, v + 1)))
          edges_.down(u, v) = all.down(u, v);
      }
    }
  }

  // Replaces wild normals; gives the view without them.
  RangeView screen(RangeView& view) {
    if (options_.robust_rounds == 0) return view;
    ScreenedNormals screened = screen_normals(view);
    RangeView trusted = without(view, screened.isolated);
    view.normals = std::move(screened.normals);
    result_.replaced_normals = screened.count;
    return trusted;
  }

  void turn_contradicted_normals(const NoiseEstimate& estimate) {
    const CoherentErrors errors = coherent_errors(problem_, estimate, noise_.spacing);
    if (errors.samples == 0) return;
    result_.outlier_normals = errors.samples;
    result_.view.normals = subtract_bias(result_.view, problem_, errors.slopes);
    problem_ = make_view_problem(result_.view, edges_, options_.stencil);
  }

  RefineStatus why_empty() const {
    const bool unconstrained = slope_constraints(result_.view, edges_, options_.stencil).empty();
    return unconstrained ? RefineStatus::kNoNormals : RefineStatus::kNoConfidence;
  }

  bool correct_first() {
    const double scale = options_.smoothing_scale.value_or(noise_.crossover());
    TwoStepResult corrected = two_step_correction(result_.view, edges_, problem_, scale);
    if (!corrected.solved) return stop(RefineStatus::kSolverFailed);
    result_.view.normals = std::move(corrected.normals);
    problem_ = make_view_problem(result_.view, edges_, options_.stencil);
    return true;
  }

  // Whether the normals bent the surface by more than refining takes of its noise. Sigmas that are
  // given are believed.
  bool contradicts(const Eigen::VectorXd& y) const {
    if (options_.lambda || options_.sigma_normal) return false;
    const double step = ranges_.noise.rounded() ? ranges_.noise.step : 0.0;
    return smooth_change(problem_, y.head(static_cast<Eigen::Index>(problem_.size())), step).bent();
  }

  void finish(const RobustSolve& solved) {
    const Eigen::VectorXd& y = solved.y;
    const auto count = static_cast<Eigen::Index>(problem_.size());
    result_.spectrum = deviation_spectrum(range_steps(result_.view, edges_), moved_by(y));
    move_samples(problem_, y, result_.view);
    if (y.size() > count) {
      const Eigen::VectorXd bias = y.tail(2 * count);
      result_.view.normals = subtract_bias(result_.view, problem_, bias);
      result_.bias_rms = rms(bias);
    }
    Grid<float> deviation;
    if (solved.deviation.size() > 0)
      deviation = deviations(result_.view, problem_, noise_.sigma_position, solved.deviation);
    result_.view.confidence = std::move(ranges_.confidence);
    result_.view.deviation = std::move(deviation);
    result_.view.samples = SampleOrigin::kRefined;
    result_.flying = ranges_.flying;
    result_.filled = ranges_.filled;
    result_.rms_change = rms(y.head(count));
    result_.refined = problem_.size();
    result_.kept = problem_.pinned;
    result_.sigma_position = noise_.sigma_position;
    result_.sigma_normal = noise_.sigma_normal;
    result_.lambda = equivalent_lambda(noise_);
  }

  Grid<float> moved_by(const Eigen::VectorXd& y) const {
    Grid<float> moved(result_.view.width(), result_.view.height(), 0.0f);
    for_each_sample(problem_, [&](Eigen::Index k, std::uint32_t pixel) {
      moved(problem_.grid.u(pixel), problem_.grid.v(pixel)) = static_cast<float>(y[k]);
    });
    return moved;
  }

  const RangeView& measured_;
  RefineOptions options_;
  PreparedView ranges_;
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
    case RefineStatus::kNoiseUnknown:
      return "noise unknown";
    case RefineStatus::kContradiction:
      return "ranges and normals contradict each other";
    case RefineStatus::kNotConverged:
      return "not converged";
    case RefineStatus::kSolverFailed:
      return "solver failed";
  }
  return "";
}

namespace {

Result<RefinedView> refine_all_of(const RangeView& view, const RefineOptions& options,
                                  const Context& context) {
  Refinement refinement(view, options);
  if (refinement.prepare() && !refinement.solve(context))
    return Error{ErrorKind::kInterrupted, "refine: stopped on request"};
  return std::move(refinement.result());
}

Result<RefinedView> refine_without_margins(const RangeView& view, const RefineOptions& options,
                                           const Context& context) {
  const ViewPart part = part_to_refine(view);
  if (part.pixels() == view.range.size()) return refine_all_of(view, options, context);
  auto result = refine_all_of(crop(view, part), options, context);
  if (result) result->view = with_part(view, part, std::move(result->view));
  return result;
}

}  // namespace

Result<RefinedView> refine_view(const RangeView& view, const RefineOptions& options,
                                const Context& context) {
  const Stopwatch watch;
  if (const Result<void> valid = validate(options); !valid) return valid.error();
  return run_in(context, [&]() -> Result<RefinedView> {
    auto result = refine_without_margins(view, options, context);
    if (result) result->seconds = watch.seconds();
    return result;
  });
}

}  // namespace relief::hybrid
