#include "registration/calibration/sensor_error_covariance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "registration/calibration/calibration_input.h"
#include "registration/calibration/corrected_views.h"
#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/estimation/fold_system.h"
#include "registration/calibration/estimation/reduced_sum.h"
#include "registration/calibration/model/error_model.h"
#include "registration/calibration/selection/held_out.h"
#include "registration/pairwise/robust.h"
#include "registration/posegraph/pose_step.h"
#include "registration/posegraph/view_graph.h"
#include "scan/base/linear_algebra.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Samples of the source, per direction of a pair. Bounds the time.
constexpr std::size_t kSamples = 1500;
// Part of the sum of squares that an error must take away: samples move by a tenth of the deviation
// of distances. The bias that noise near the spacing gives interpolated ranges takes 0.004.
constexpr double kLeastPart = 0.01;
// Deviation of a coefficient before any correspondence is known, in deviations of the distances of
// views. Poses take most of an error up: wrong focal lengths, range offsets and drifts of rooms and
// objects moved samples by 7 to 10 times what was left between the views.
constexpr double kPriorFactor = 8.0;

// Distances along the rays that are read as depths have a coefficient of 1. An estimate is nearer
// to that than to 0 or 2: a statue gave 0.72, as matches at poses that are off hide a part.
constexpr double kWholeError = 1.0, kWholeTolerance = 0.5;

// An error of the sensors, and what it moves the poses by.
struct Explanation {
  ErrorChoice choice;
  std::array<double, kFolds> gains{};  // Of held-out correspondences (C3).
  HeldOutGain gain;
  double coefficient = 0.0;                     // The first, in natural units, mean of the folds.
  std::array<Eigen::VectorXd, kFolds> motions;  // Of all poses, by the other folds.
};

std::vector<double> spacings_of(const std::vector<ViewSurface>& surfaces) {
  std::vector<double> spacings;
  for (const ViewSurface& surface : surfaces) spacings.push_back(surface.spacing());
  return spacings;
}

// Whether the scale of the ranges, where all views share it, cannot be told from that of the scene.
bool no_view_shows_scale(const Sensors& sensors) {
  return sensors.models.size() == 1 && sensors.models.front().scales_all();
}

// All that the sensors may have wrong but the overall scale.
std::vector<ErrorChoice> candidates(const Sensors& sensors, bool per_view) {
  std::vector<ErrorChoice> choices;
  for (const SensorModel& sensor : sensors.models) {
    for (std::size_t k = 0; k < sensor.terms(); ++k) {
      for (const bool apart : {false, true}) {
        const ErrorChoice choice{sensor.error_of(k), apart};
        const bool overall_scale =
            choice.error == SensorError::kRangeScale && !apart && no_view_shows_scale(sensors);
        if (overall_scale || (apart && !per_view)) continue;
        if (choice.error == SensorError::kRayLengths) continue;  // See ray_lengths().
        if (std::find(choices.begin(), choices.end(), choice) == choices.end())
          choices.push_back(choice);
      }
    }
  }
  return choices;
}

class Explaining {
 public:
  // `deviation`: the median_deviation() of the pairs.
  Explaining(FoldSystem system, double deviation, const Sensors& sensors)
      : sensors_(sensors),
        prior_(kPriorFactor * deviation / sensors.models.front().spacing()),
        system_(std::move(system)) {
    parallel_for(kFolds, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        train_[f] = system_.folds[f].train(system_.layout);
        test_[f] = system_.folds[f].test(system_.layout);
      }
    });
  }

  // The errors that explain the distances best: the one that gains most, and those that gain as
  // much to within a standard error of that (Hastie, Tibshirani and Friedman 2009, section 7.10).
  std::vector<Explanation> best() const {
    std::vector<Explanation> found;
    for (const ErrorChoice& choice : candidates(sensors_, system_.layout.per_view))
      if (auto explanation = explain(choice); is_real(explanation))
        found.push_back(std::move(explanation));
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.gain.gain > b.gain.gain; });
    if (found.empty()) return found;
    const double least = found.front().gain.gain - found.front().gain.deviation;
    std::erase_if(found,
                  [&](const Explanation& explanation) { return explanation.gain.gain < least; });
    return found;
  }

  // Distances along the rays that are read as depths, where these explain as much as the best
  // error, to within chance, and have about the size that they must have.
  std::optional<Explanation> ray_lengths(const Explanation& best) const {
    Explanation explanation = explain({SensorError::kRayLengths, false});
    std::array<double, kFolds> less{};
    for (std::size_t f = 0; f < kFolds; ++f) less[f] = best.gains[f] - explanation.gains[f];
    const bool whole = std::abs(explanation.coefficient - kWholeError) <= kWholeTolerance;
    if (!whole || !is_real(explanation) || sum_of_gains(less, 1.0).is_beyond_chance())
      return std::nullopt;
    return explanation;
  }

  // The second moment of what the errors may have moved a view by, each as likely as the others.
  Matrix6d second_moment(const std::vector<Explanation>& explanations, std::size_t view) const {
    Matrix6d sum = Matrix6d::Zero();
    const Eigen::Index at = system_.layout.pose[view];
    if (at < 0) return sum;
    constexpr auto kCount = static_cast<double>(kFolds);
    for (const Explanation& explanation : explanations) {
      RigidTangent mean = RigidTangent::Zero();
      for (const Eigen::VectorXd& motion : explanation.motions)
        mean += motion.segment<6>(at) / kCount;
      sum += mean * mean.transpose();
      for (const Eigen::VectorXd& motion : explanation.motions) {  // The jackknife (Efron 1982).
        const RigidTangent apart = motion.segment<6>(at) - mean;
        sum += (kCount - 1.0) / kCount * apart * apart.transpose();
      }
    }
    return sum / static_cast<double>(explanations.size());
  }

 private:
  // Whether held-out correspondences gain more than by chance, and enough to matter.
  static bool is_real(const Explanation& explanation) {
    return explanation.gain.is_beyond_chance() && explanation.gain.gain > kLeastPart;
  }

  Explanation explain(const ErrorChoice& choice) const {
    ErrorModel model;
    model.add(choice, sensors_);
    Explanation explanation;
    explanation.choice = choice;
    if (model.parameters.empty()) return explanation;
    const auto places = system_.layout.coefficients_of(model, sensors_);
    for (std::size_t f = 0; f < kFolds; ++f) {
      ReducedSum train = train_[f].by_parameters(places);
      train.matrix.diagonal().array() += 1.0 / (prior_ * prior_);
      if (choice.error == SensorError::kRangeScale && no_view_shows_scale(sensors_))
        train.matrix.array() += train.matrix.trace();  // The mean over the views stays at 0.
      const Eigen::VectorXd step = -solve_symmetric(train.matrix, train.gradient);
      explanation.gains[f] = test_[f].by_parameters(places).fall(step) / system_.squares;
      explanation.coefficient += natural_first(model, step) / static_cast<double>(kFolds);
      explanation.motions[f] =
          system_.folds[f].poses_of_others.slope() * at_coefficients(step, places);
    }
    explanation.gain = sum_of_gains(explanation.gains, 1.0);
    return explanation;
  }

  // Of the first parameter.
  double natural_first(const ErrorModel& model, const Eigen::VectorXd& step) const {
    const ErrorParameter& first = model.parameters.front();
    const std::size_t sensor =
        model.choices.front().per_view ? sensors_.of_view[first.owner] : first.owner;
    return sensors_.models[sensor].natural(first.term, step[0]);
  }

  Eigen::VectorXd at_coefficients(const Eigen::VectorXd& parameters,
                                  const std::vector<std::vector<Eigen::Index>>& places) const {
    Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(system_.layout.coefficients);
    for (std::size_t p = 0; p < places.size(); ++p)
      for (const Eigen::Index c : places[p])
        coefficients[c] += parameters[static_cast<Eigen::Index>(p)];
    return coefficients;
  }

  const Sensors& sensors_;
  double prior_;  // Deviation of a coefficient [sample spacings].
  FoldSystem system_;
  std::array<ReducedSum, kFolds> train_, test_;  // Of all coefficients.
};

Explaining explaining_pairs(const CalibratedViews& measured, const std::vector<ViewPair>& pairs,
                            const CalibrationSumOptions& options, const std::vector<bool>& held) {
  const Sensors& sensors = *measured.sensors;
  const SystemLayout layout(sensors, held, may_err_apart(sensors));
  FoldSums sums = empty_folds(layout);
  std::vector<double> deviations;
  for_each_pair_sums(measured, pairs, options, [&](const PairSums& pair) {
    add_pair(pair, sensors, layout, sums);
    deviations.push_back(pair.deviation);
  });
  return {FoldSystem(layout, std::move(sums)), median_deviation(std::move(deviations)), sensors};
}

std::string describe(const Explanation& explanation, double motion) {
  const bool read_wrongly = explanation.choice.error == SensorError::kRayLengths;
  char text[400];
  std::snprintf(
      text, sizeof text,
      "views disagree by more than noise explains: an error like %s%s explains %.2g %% "
      "of their squared distances and moves the median view by %.2g; the deviations of "
      "poses include that, and %s",
      std::string(to_string(explanation.choice.error)).c_str(),
      explanation.choice.per_view ? " (one per view)" : "", 100.0 * explanation.gain.gain, motion,
      read_wrongly ? "if the depth images hold such distances, give their views \"kind\": "
                     "\"ray\" in `depth`"
                   : "calibrating may correct it");
  return text;
}

}  // namespace

void include_sensor_errors(const std::vector<RangeView>& views,
                           const std::vector<ViewSurface>& surfaces,
                           const JointRefinementOptions& refinement, Alignment& alignment) {
  const auto pairs = fitting_pairs(alignment);
  const Sensors sensors = find_sensors(pointers_to(views), spacings_of(surfaces));
  if (!can_see_sensor_errors(alignment, pairs, sensors)) return;
  const CalibratedViews measured =
      calibrated_views(views, views, surfaces, sensors, alignment.world_from_view(), pairs);
  const Explaining explaining = explaining_pairs(
      measured, pairs, sum_options(surfaces, refinement, kSamples), held_views(views, pairs));
  const auto explanations = explaining.best();
  if (explanations.empty()) return;
  const auto ray_lengths = explaining.ray_lengths(explanations.front());
  std::vector<double> motions;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Matrix6d about_view =
        tangents_about(measured.world_from_view[i] * surfaces[i].centre() - measured.centre);
    const Matrix6d moment =
        about_view * explaining.second_moment(explanations, i) * about_view.transpose();
    if (moment.isZero(0.0) || !moment.allFinite()) continue;
    ViewReport& view = alignment.views[i];
    view.sensor_covariance = moment;
    view.pose_covariance += moment;
    view.pose_std = view.pose_covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    motions.push_back(std::sqrt(moment.diagonal().tail<3>().sum()));
  }
  if (!motions.empty())
    alignment.sensor_error = describe(ray_lengths ? *ray_lengths : explanations.front(),
                                      quantile(std::move(motions), 0.5));
}

}  // namespace relief::registration
