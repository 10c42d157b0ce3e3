#include "relief/registration/calibrate_views.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "registration/align_surfaces.h"
#include "registration/calibration/calibration_input.h"
#include "registration/calibration/calibration_notes.h"
#include "registration/calibration/corrected_alignment.h"
#include "registration/calibration/corrected_views.h"
#include "registration/calibration/estimation/calibration_problem.h"
#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/estimation/fold_system.h"
#include "registration/calibration/estimation/pose_inflation.h"
#include "registration/calibration/model/error_model.h"
#include "registration/calibration/pairwise_fit.h"
#include "registration/calibration/selection/held_out.h"
#include "registration/calibration/selection/left_out_views.h"
#include "registration/calibration/selection/term_selection.h"
#include "registration/distinct_views.h"
#include "registration/pairwise/robust.h"
#include "registration/posegraph/pose_step.h"
#include "registration/posegraph/refinement/pose_graph_refinement.h"
#include "registration/posegraph/view_graph.h"
#include "registration/prepared_views.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Renewals of the correspondences at most. Errors of half a percent of the focal length come to
// rest in three.
constexpr int kMostIterations = 6;
// Coefficients and poses have come to rest when they move samples by no more [sample spacings]: as
// much as the poses of exact data err by.
constexpr double kTolerance = 0.01;

std::vector<double> spacings_of(const std::vector<RangeView>& views) {
  return parallel_map<double>(views.size(),
                              [&](std::size_t i) { return sample_spacing(views[i]); });
}

AlignOptions with_index(AlignOptions align) {
  align.surface = surface_options(align);
  return align;
}

class Calibrating {
 public:
  Calibrating(const std::vector<RangeView>& views, const Alignment& aligned,
              const AlignOptions& align, const CalibrationOptions& options,
              const Progress& progress)
      : given_(views),
        aligned_(aligned),
        options_(options),
        progress_(progress),
        pairs_(fitting_pairs(aligned)),
        held_(held_views(views, pairs_)),
        sensors_(find_sensors(pointers_to(views), spacings_of(views))),
        poses_(aligned.world_from_view()),
        corrected_(views, sensors_, with_index(align)) {}

  Result<SensorCalibration> run() {
    if (options_.scope == CalibrationScope::kOff || !can_be_calibrated(aligned_, pairs_, sensors_))
      return std::move(result_);
    for (bool moving = true; moving && result_.iterations < kMostIterations;) {
      if (const auto corrected = correct(false); !corrected) return corrected.error();
      const auto sums = corrected_.sum(poses_, pairs_, static_cast<std::size_t>(options_.samples));
      result_.deviation_after = median_deviation(sums);
      if (result_.iterations == 0) start();
      if (result_.iterations == 0) select(sums);
      if (model_.choices.empty()) break;
      if (result_.iterations == 0) fit_before_ = fit_of(corrected_, poses_, pairs_);
      moving = step(sums);
      ++result_.iterations;
      if (moving && result_.iterations < kMostIterations) continue;
      inflation_ = pose_inflation(sums, sensors_, model_, held_);
      describe(HeldOutTest(fold_system(sums), sums, sensors_).fit(model_));
    }
    note_errors_per_view(result_);
    if (model_.choices.empty()) return std::move(result_);
    if (const auto corrected = correct(true); !corrected) return corrected.error();
    if (const auto aligned = align(); !aligned) return aligned.error();
    if (!result_.alignment.solved() ||
        !fits_better(fit_of(corrected_, result_.alignment.world_from_view(), pairs_), fit_before_))
      return nothing_found();
    if (const auto again = align_from_given_poses(); !again) return again.error();
    return std::move(result_);
  }

 private:
  FoldSystem fold_system(const std::vector<PairSums>& sums) const {
    const bool apart = options_.scope != CalibrationScope::kShared && may_err_apart(sensors_);
    return registration::fold_system(sums, sensors_, held_, apart);
  }

  // Other places of the same views confirm what other views do not: a view's local errors.
  void note_errors_per_view(SensorCalibration& calibration) const {
    if (unconfirmed_gain_ == 0.0) return;
    char text[200];
    std::snprintf(text, sizeof text,
                  "views err each in its own way: ranges of single views would lower the squared "
                  "distances by %.2g %%, which views left out do not confirm; the scope per-view "
                  "corrects them",
                  100.0 * unconfirmed_gain_);
    calibration.notes.emplace_back(text);
  }

  // What the held-out samples promised did not come true.
  SensorCalibration nothing_found() const {
    SensorCalibration nothing;
    nothing.deviation_before = nothing.deviation_after = result_.deviation_before;
    note_errors_per_view(nothing);
    return nothing;
  }

  // The views fit each other to what their errors leave, so that is about what errors are.
  void start() {
    result_.deviation_before = result_.deviation_after;
    model_.prior_deviation = result_.deviation_before / sensors_.models.front().spacing();
  }

  Result<void> correct(bool with_normals) {
    return corrected_.correct(model_, with_normals, [&](double part) {
      const double fraction = (result_.iterations + part) / (kMostIterations + 1);
      return report_progress(progress_, fraction, "calibrating sensors");
    });
  }

  void select(const std::vector<PairSums>& sums) {
    const FoldSystem system = fold_system(sums);
    const SelectedErrors selected =
        select_errors(HeldOutTest(system, sums, sensors_), LeftOutViewsTest(system, sums, sensors_),
                      sensors_, options_.scope, model_);
    for (std::size_t c = 0; c < model_.choices.size(); ++c) {
      CalibratedError error;
      error.error = model_.choices[c].error;
      error.per_view = model_.choices[c].per_view;
      const auto& [places, views] = selected.gains[c];
      error.held_out_gain = places.gain;
      error.held_out_gain_std = places.deviation;
      error.left_out_views_gain = views.gain;
      error.left_out_views_gain_std = views.deviation;
      result_.errors.push_back(error);
    }
    unconfirmed_gain_ = selected.unconfirmed_gain;
  }

  // Whether poses or errors still moved.
  bool step(const std::vector<PairSums>& sums) {
    const CalibrationStep found = solve_calibration(sums, sensors_, model_, held_);
    solves_.push_back(found.summary);
    if (!found.usable()) return false;
    double largest = 0.0;
    const auto parameters_before = model_.parameters;
    for (std::size_t p = 0; p < model_.parameters.size(); ++p)
      model_.parameters[p].value += found.errors[p];
    const auto before = poses_;
    for (std::size_t i = 0; i < held_.size(); ++i)
      if (!found.tangents[i].isZero(0.0))
        poses_[i] = moved(before[i], found.tangents[i], corrected_.centre());
    keep_scale_of_most();
    for (std::size_t p = 0; p < model_.parameters.size(); ++p)
      largest =
          std::max(largest, std::abs(model_.parameters[p].value - parameters_before[p].value));
    const double motion =
        largest_motion(registration::pointers_to(corrected_.surfaces()), before, poses_);
    return largest > kTolerance || motion > kTolerance * sensors_.models.front().spacing();
  }

  // What is wrong with the scale of one view does not shrink all others. Several known poses tell
  // the scale themselves.
  void keep_scale_of_most() {
    const auto known = [](const RangeView& view) { return view.pose == PoseKind::kKnown; };
    if (std::count_if(given_.begin(), given_.end(), known) > 1) return;
    const double ratio = take_median_scale(model_, sensors_);
    const auto group = connected_groups(given_.size(), pairs_);
    const std::vector<RigidMotion> unscaled = poses_;
    for (std::size_t i = 0; i < held_.size(); ++i)
      for (std::size_t j = 0; j < held_.size(); ++j)
        if (held_[j] && group[i] == group[j])
          poses_[i].translation() -=
              ratio * (unscaled[i].translation() - unscaled[j].translation());
  }

  void describe(const HeldOutFit& fit) {
    const std::vector<double> deviations = jackknife_deviations(fit);
    ErrorModel deviation = model_;
    for (std::size_t p = 0; p < deviations.size(); ++p)
      deviation.parameters[p].value = deviations[p];
    for (std::size_t i = 0; i < given_.size(); ++i)
      result_.views.push_back({sensors_.of_view[i], model_.coefficients(i, sensors_),
                               deviation.coefficients(i, sensors_)});
    std::vector<std::string> names;
    for (const RangeView& view : given_) names.push_back(view.name);
    describe_errors(sensors_, names, model_, deviation, result_);
  }

  Result<void> align() {
    Alignment so_far = aligned_;
    so_far.iterations += result_.iterations;
    so_far.solves.insert(so_far.solves.end(), solves_.begin(), solves_.end());
    auto aligned = align_corrected(corrected_, so_far, poses_, inflation_);
    if (!aligned) return aligned.error();
    result_.alignment = *std::move(aligned);
    return {};
  }

  // A wrong sensor may tear views apart, refute right poses, or lead away from exact ones.
  Result<void> align_from_given_poses() {
    if (!may_gain_from_given(corrected_, aligned_, result_.alignment)) return {};
    auto again = align_from_given(corrected_, result_.alignment, inflation_, progress_);
    if (!again) return again.error();
    const std::size_t verified = verified_views(*again), before = verified_views(result_.alignment);
    if (verified < before || aligned_views(*again) < aligned_views(result_.alignment) ||
        !again->solved() ||
        !fits_better(fit_of(corrected_, again->world_from_view(), pairs_), fit_before_))
      return {};
    result_.alignment = std::move(*again);
    result_.notes.push_back("the corrected views were aligned again from their given poses: " +
                            std::to_string(verified) + " views are verified, " +
                            std::to_string(before) + " were before");
    return {};
  }

  const std::vector<RangeView>& given_;
  const Alignment& aligned_;
  CalibrationOptions options_;
  const Progress& progress_;
  std::vector<ViewPair> pairs_;
  std::vector<bool> held_;
  Sensors sensors_;
  std::vector<RigidMotion> poses_;
  CorrectedViews corrected_;
  ErrorModel model_;
  PairwiseFit fit_before_;  // Of the views as given.
  std::vector<RigidTangent> inflation_;
  std::vector<SolverSummary> solves_;
  double unconfirmed_gain_ = 0.0;
  SensorCalibration result_;
};

}  // namespace

Result<SensorCalibration> calibrate_views(const std::vector<RangeView>& views,
                                          const Alignment& aligned, const AlignOptions& align,
                                          const CalibrationOptions& options,
                                          const Context& context) {
  if (views.empty() || aligned.views.size() != views.size())
    return Error{ErrorKind::kBadInput, "calibration: the alignment is not that of the views"};
  if (options.samples < 100)
    return Error{ErrorKind::kBadInput, "calibration options: samples must be >= 100"};
  return run_in(context, [&]() -> Result<SensorCalibration> {
    const DistinctViews distinct(views);
    const Alignment given = distinct.without_copies(aligned);
    auto found = Calibrating(distinct.views(), given, align, options, context.progress).run();
    if (!found) return found;
    return distinct.with_copies(*std::move(found));
  });
}

void apply_calibration(const SensorCalibration& calibration, std::vector<RangeView>& views) {
  if (!calibration.found()) return;
  const DistinctViews distinct(views);
  const Sensors sensors =
      find_sensors(pointers_to(distinct.views()), spacings_of(distinct.views()));
  views = parallel_map<RangeView>(views.size(), [&](std::size_t i) {
    return sensors.models[sensors.of_view[distinct.place_of(i)]].corrected(
        views[i], calibration.views[i].coefficients);
  });
  apply_alignment(calibration.alignment, views);
}

}  // namespace relief::registration
