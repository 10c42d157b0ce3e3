#include "registration/calibration/selection/term_selection.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace relief::registration {

namespace {

// Standard errors by which the gain of the folds must exceed 0: Student's t of four degrees of
// freedom lies beyond with a probability of 0.005. There are two dozen candidates.
constexpr double kLeastGain = 4.6;

// Part of the sum of squares that an error must take away. Its square root is how far the error
// moves samples along their normals, in deviations of the residuals: less is below three hundredths
// of the noise of one sample.
constexpr double kLeastPart = 1e-3;

// Views may move by so many deviations of their distances. Half a percent of the focal length takes
// two (docs/results.md, Calibration).
constexpr double kMostMotion = 3.0;
constexpr int kPriorSteps = 16;  // Each halves the prior.

// With one sensor whose rays start from one point, the scale of its ranges is that of everything.
constexpr ErrorChoice kOverallScale{SensorError::kRangeScale, false};

// A lens stays as it is between views. Ranges drift with temperature and time.
bool of_range(SensorError error) { return error <= SensorError::kQuarticWarp; }

std::vector<ErrorChoice> candidates(const Sensors& sensors, bool per_view) {
  std::vector<ErrorChoice> choices;
  for (const SensorModel& sensor : sensors.models) {
    for (std::size_t k = 0; k < sensor.terms(); ++k) {
      const ErrorChoice choice{sensor.error_of(k), per_view};
      if (per_view && !of_range(choice.error)) continue;
      if (choice == kOverallScale && sensors.models.size() == 1 && sensor.scales_all()) continue;
      if (std::find(choices.begin(), choices.end(), choice) == choices.end())
        choices.push_back(choice);
    }
  }
  return choices;
}

// Of one model over another, relative to `squares`.
HeldOutGain gain_over(const HeldOutFit& before, const HeldOutFit& after, double squares) {
  HeldOutGain result;
  double sum = 0.0, sum_of_squares = 0.0;
  for (std::size_t f = 0; f < kFolds; ++f) {
    const double gain = (after.gain[f] - before.gain[f]) / squares;
    sum += gain;
    sum_of_squares += gain * gain;
  }
  constexpr auto kCount = static_cast<double>(kFolds);
  const double variance = std::max(0.0, sum_of_squares - sum * sum / kCount) / (kCount - 1.0);
  result.gain = sum;
  result.deviation = std::sqrt(kCount * variance);
  return result;
}

struct Extension {
  ErrorModel model;
  HeldOutFit fit;
  HeldOutGain gain;
};

std::optional<Extension> best_extension(const HeldOutTest& test, const Sensors& sensors,
                                        const std::vector<ErrorChoice>& choices,
                                        const ErrorModel& model, const HeldOutFit& before) {
  std::optional<Extension> best;
  for (const ErrorChoice& choice : choices) {
    if (model.has(choice)) continue;
    ErrorModel extended = model;
    extended.add(choice, sensors);
    HeldOutFit fit = test.fit(extended);
    const HeldOutGain gain = gain_over(before, fit, test.squares());
    if (!(gain.gain > kLeastPart && gain.gain > kLeastGain * gain.deviation)) continue;
    if (!best || gain.gain > best->gain.gain) best = {std::move(extended), std::move(fit), gain};
  }
  return best;
}

// The root mean square over the views of what a model moves samples by [sample spacings], about:
// the fields of the terms are scaled to one spacing.
double size_of(const ErrorModel& model, const Sensors& sensors) {
  double squares = 0.0;
  for (std::size_t view = 0; view < sensors.of_view.size(); ++view)
    for (const double c : model.coefficients(view, sensors)) squares += c * c;
  return std::sqrt(squares / static_cast<double>(sensors.of_view.size()));
}

// Calibrations that bend all views alike hardly show between them, and small errors of other kinds
// would call for large ones. So views must not move by much more than they disagree by: the prior
// is narrowed until they do not.
void narrow_prior(const HeldOutTest& test, const Sensors& sensors, ErrorModel& model) {
  const double most = kMostMotion * model.prior_deviation;
  ErrorModel moved = model;
  for (int step = 0; step < kPriorSteps; ++step) {
    const HeldOutFit fit = test.fit(model);
    for (std::size_t p = 0; p < moved.parameters.size(); ++p) {
      moved.parameters[p].value = 0.0;
      for (const Eigen::VectorXd& of_fold : fit.step)
        moved.parameters[p].value += of_fold[static_cast<Eigen::Index>(p)] / kFolds;
    }
    if (size_of(moved, sensors) <= most) return;
    model.prior_deviation *= 0.5;
  }
}

}  // namespace

SelectedErrors select_errors(const HeldOutTest& test, const Sensors& sensors,
                             CalibrationScope scope, ErrorModel& model) {
  SelectedErrors selected;
  HeldOutFit fit = test.fit(model);
  const auto add_best_of = [&](const std::vector<ErrorChoice>& choices) {
    while (auto best = best_extension(test, sensors, choices, model, fit)) {
      model = std::move(best->model);
      fit = std::move(best->fit);
      selected.gains.push_back(best->gain);
    }
  };
  add_best_of(candidates(sensors, false));
  if (test.per_view() && scope == CalibrationScope::kPerView)
    add_best_of(candidates(sensors, true));
  else if (test.per_view() && scope == CalibrationScope::kAuto)
    if (const auto best = best_extension(test, sensors, candidates(sensors, true), model, fit))
      selected.gain_per_view = best->gain.gain;
  if (!selected.gains.empty()) narrow_prior(test, sensors, model);
  return selected;
}

}  // namespace relief::registration
