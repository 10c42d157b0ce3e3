#include "registration/calibration/selection/term_selection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace relief::registration {

namespace {

// The same of the views left out, by the degrees of freedom from 1: Student's t lies beyond with a
// probability of 0.025. They confirm an error that the folds found.
constexpr std::array kLeastGainOfViews = {12.7, 4.30, 3.18, 2.78, 2.57, 2.45,
                                          2.36, 2.31, 2.26, 2.23, 2.20};

// The gains of two views share the pair of both, so the variance of their sum is twice what that of
// the views tells.
constexpr double kSharedPairs = 2.0;

// Part of the sum of squares that an error must take away. Its square root is how far the error
// moves samples along their normals, in deviations of the residuals: less is below three hundredths
// of the noise of one sample.
constexpr double kLeastPart = 1e-3;

// Views may move by so many deviations of their distances. Half a percent of the focal length takes
// two (docs/results.md, Calibration).
constexpr double kMostMotion = 3.0;
constexpr int kPriorSteps = 16;  // Each halves the prior.

// Widths of the prior that are tried, in deviations of the distances of views.
constexpr std::array kPriorFactors = {0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0};

// With one sensor whose rays start from one point, the scale of its ranges is that of everything.
constexpr ErrorChoice kOverallScale{SensorError::kRangeScale, false};

// A lens stays as it is between views. Ranges drift with temperature and time.
bool of_range(SensorError error) { return error <= SensorError::kQuarticWarp; }

std::vector<ErrorChoice> candidates(const Sensors& sensors, bool per_view) {
  std::vector<ErrorChoice> choices;
  for (const SensorModel& sensor : sensors.models) {
    for (std::size_t k = 0; k < sensor.terms(); ++k) {
      const ErrorChoice choice{sensor.error_of(k), per_view};
      if (choice.error == SensorError::kRayLengths) continue;  // Files have them wholly or not.
      if (per_view && !of_range(choice.error)) continue;
      if (choice == kOverallScale && sensors.models.size() == 1 && sensor.scales_all()) continue;
      if (std::find(choices.begin(), choices.end(), choice) == choices.end())
        choices.push_back(choice);
    }
  }
  return choices;
}

bool confirmed(const HeldOutGain& of_views, std::size_t groups) {
  if (groups < 2) return false;
  const std::size_t freedom = std::min(groups - 1, kLeastGainOfViews.size());
  return of_views.gain > kLeastGainOfViews[freedom - 1] * of_views.deviation;
}

// What is known of a model: how well it fits places and views that took no part.
struct Fit {
  HeldOutFit places;
  std::vector<double> views;
};

template <class Parts>
std::vector<double> differences(const Parts& after, const Parts& before) {
  std::vector<double> result;
  for (std::size_t i = 0; i < after.size(); ++i) result.push_back(after[i] - before[i]);
  return result;
}

struct Extension {
  ErrorModel model;
  Fit fit;
  ErrorGain gain;
};

class Selecting {
 public:
  Selecting(const HeldOutTest& places, const LeftOutViewsTest& views, const Sensors& sensors)
      : places_(places), views_(views), sensors_(sensors) {}

  Fit fit(const ErrorModel& model) const { return {places_.fit(model), views_.gains(model)}; }

  // The model with the one of `choices` that gains most, if any gains by more than chance.
  // `confirm`: at views that took no part as well.
  std::optional<Extension> best_extension(const std::vector<ErrorChoice>& choices,
                                          const ErrorModel& model, const Fit& before,
                                          bool confirm) const {
    std::optional<Extension> best;
    for (const ErrorChoice& choice : choices) {
      if (model.has(choice)) continue;
      auto extension = extend(model, choice, before, confirm);
      if (extension && (!best || extension->gain.places.gain > best->gain.places.gain))
        best = std::move(extension);
    }
    return best;
  }

 private:
  std::optional<Extension> extend(const ErrorModel& model, const ErrorChoice& choice,
                                  const Fit& before, bool confirm) const {
    Extension extension;
    extension.model = model;
    extension.model.add(choice, sensors_);
    extension.fit.places = places_.fit(extension.model);
    HeldOutGain& of_places = extension.gain.places;
    of_places =
        sum_of_gains(differences(extension.fit.places.gain, before.places.gain), places_.squares());
    if (of_places.gain <= kLeastPart || of_places.gain <= kLeastGain * of_places.deviation)
      return std::nullopt;
    extension.fit.views = views_.gains(extension.model);
    HeldOutGain& of_views = extension.gain.views;
    of_views = sum_of_gains(differences(extension.fit.views, before.views), places_.squares());
    of_views.deviation *= std::sqrt(kSharedPairs);
    if (confirm && !confirmed(of_views, extension.fit.views.size())) return std::nullopt;
    return extension;
  }

  const HeldOutTest& places_;
  const LeftOutViewsTest& views_;
  const Sensors& sensors_;
};

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

// What holds for views left out: the prior is as wide as they gain most by.
void choose_prior(const LeftOutViewsTest& views, ErrorModel& model) {
  ErrorModel trial = model;
  double chosen = model.prior_deviation, best = -std::numeric_limits<double>::infinity();
  for (const double factor : kPriorFactors) {
    trial.prior_deviation = factor * model.prior_deviation;
    const std::vector<double> gains = views.gains(trial);
    const double gain = std::accumulate(gains.begin(), gains.end(), 0.0);
    if (gain <= best) continue;
    best = gain;
    chosen = trial.prior_deviation;
  }
  model.prior_deviation = chosen;
}

}  // namespace

SelectedErrors select_errors(const HeldOutTest& places, const LeftOutViewsTest& views,
                             const Sensors& sensors, CalibrationScope scope, ErrorModel& model) {
  const Selecting selecting(places, views, sensors);
  SelectedErrors selected;
  Fit fit = selecting.fit(model);
  const auto add_best_of = [&](const std::vector<ErrorChoice>& choices, bool confirm) {
    while (auto best = selecting.best_extension(choices, model, fit, confirm)) {
      model = std::move(best->model);
      fit = std::move(best->fit);
      selected.gains.push_back(best->gain);
    }
  };
  add_best_of(candidates(sensors, false), true);
  if (places.per_view()) {
    const auto of_views = candidates(sensors, true);
    add_best_of(of_views, scope != CalibrationScope::kPerView);
    if (const auto best = selecting.best_extension(of_views, model, fit, false))
      selected.unconfirmed_gain = best->gain.places.gain;
  }
  if (selected.gains.empty()) return selected;
  if (scope == CalibrationScope::kPerView)
    narrow_prior(places, sensors, model);
  else
    choose_prior(views, model);
  return selected;
}

}  // namespace relief::registration
