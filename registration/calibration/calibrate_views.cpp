#include "relief/registration/calibrate_views.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "registration/calibration/calibration_input.h"
#include "registration/calibration/calibration_notes.h"
#include "registration/calibration/estimation/calibration_problem.h"
#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/estimation/fold_system.h"
#include "registration/calibration/estimation/pose_inflation.h"
#include "registration/calibration/model/error_model.h"
#include "registration/calibration/pairwise_fit.h"
#include "registration/calibration/selection/held_out.h"
#include "registration/calibration/selection/left_out_views.h"
#include "registration/calibration/selection/term_selection.h"
#include "registration/pairwise/robust.h"
#include "registration/pairwise/search_schedule.h"
#include "registration/posegraph/joint_refinement.h"
#include "registration/posegraph/pose_step.h"
#include "registration/posegraph/refinement/pose_graph_refinement.h"
#include "registration/posegraph/view_graph.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// One alone shows no error of its sensor, and two agree by a wrong pose as well.
constexpr std::size_t kFewestViews = 3;
// Renewals of the correspondences at most. Errors of half a percent of the focal length come to
// rest in three.
constexpr int kMostIterations = 6;
// Coefficients and poses have come to rest when they move samples by no more [sample spacings]: as
// much as the poses of exact data err by.
constexpr double kTolerance = 0.01;
// More views have only errors that they share: the terms of all views make a dense system, of a
// thousand unknowns for 40.
constexpr std::size_t kMostViewsApart = 40;
// More views are left as they are: all poses together make a dense system, of 13 MB and half a
// second for 200.
constexpr std::size_t kMostViews = 200;
// Edge of the cubes that are in one fold as a whole [sample spacings], as of the clusters of (R12).
constexpr double kPatch = 8.0;

// Part of the overlap that must stay: chance and the borders of views take less than a twentieth.
constexpr double kLeastOverlap = 0.95;

std::vector<double> spacings_of(const std::vector<RangeView>& views) {
  return parallel_map<double>(views.size(),
                              [&](std::size_t i) { return sample_spacing(views[i]); });
}

std::vector<const RangeView*> pointers_to(const std::vector<RangeView>& views) {
  std::vector<const RangeView*> pointers;
  for (const RangeView& view : views) pointers.push_back(&view);
  return pointers;
}

class Calibrating {
 public:
  Calibrating(const std::vector<RangeView>& views, const Alignment& aligned,
              const AlignOptions& align, const CalibrationOptions& options,
              const Progress& progress)
      : given_(views),
        aligned_(aligned),
        align_(align),
        options_(options),
        progress_(progress),
        pairs_(fitting_pairs(aligned)),
        held_(held_views(views, pairs_)),
        sensors_(find_sensors(pointers_to(views), spacings_of(views))),
        poses_(aligned.world_from_view()) {
    align_.surface.neighbour_index |= align.refinement.association == Association::kNearest;
  }

  Result<SensorCalibration> run() {
    if (options_.scope == CalibrationScope::kOff || linked_views() < kFewestViews ||
        linked_views() > kMostViews || !shape_holds_all(aligned_))
      return std::move(result_);
    for (bool moving = true; moving && result_.iterations < kMostIterations;) {
      if (const auto prepared = prepare(false); !prepared) return prepared.error();
      const auto sums = sum();
      result_.deviation_after = median_deviation(sums);
      if (result_.iterations == 0) start();
      if (result_.iterations == 0) select(sums);
      if (model_.choices.empty()) break;
      moving = step(sums);
      ++result_.iterations;
      if (moving && result_.iterations < kMostIterations) continue;
      inflation_ = pose_inflation(sums, sensors_, model_, held_);
      describe(HeldOutTest(fold_system(sums), sums, sensors_).fit(model_));
    }
    note_errors_per_view(result_);
    if (model_.choices.empty()) return std::move(result_);
    if (const auto aligned = align_corrected(); !aligned) return aligned.error();
    if (!result_.alignment.solved() || !fits_better()) return nothing_found();
    return std::move(result_);
  }

 private:
  std::size_t linked_views() const {
    std::vector<bool> linked(given_.size(), false);
    for (const ViewPair& pair : pairs_) linked[pair.a] = linked[pair.b] = true;
    return static_cast<std::size_t>(std::count(linked.begin(), linked.end(), true));
  }

  bool may_err_apart() const {
    return options_.scope != CalibrationScope::kShared && linked_views() <= kMostViewsApart;
  }

  FoldSystem fold_system(const std::vector<PairSums>& sums) const {
    return FoldSystem(sums, sensors_, held_, may_err_apart());
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

  // The views as corrected so far, and their surfaces.
  Result<void> prepare(bool with_normals) {
    surfaces_.clear();
    corrected_ = parallel_map<RangeView>(given_.size(), [&](std::size_t i) {
      const RangeView ranges = with_normals ? given_[i] : ranges_of(given_[i]);
      return model_.choices.empty() ? ranges
                                    : sensors_.models[sensors_.of_view[i]].corrected(
                                          ranges, model_.coefficients(i, sensors_));
    });
    ViewSurfaceOptions options = align_.surface;
    options.normal_signal &= with_normals;
    for (std::size_t i = 0; i < given_.size(); ++i) {
      const double fraction =
          (result_.iterations + static_cast<double>(i) / static_cast<double>(given_.size())) /
          (kMostIterations + 1);
      if (!report_progress(progress_, fraction, "calibrating sensors"))
        return Error{ErrorKind::kInterrupted, "calibration was interrupted"};
      surfaces_.emplace_back(corrected_[i], options);
    }
    return {};
  }

  std::vector<PairSums> sum() {
    calibrated_.given = &given_;
    calibrated_.surfaces = &surfaces_;
    calibrated_.sensors = &sensors_;
    calibrated_.nearby_ranges = parallel_map<Grid<double>>(
        given_.size(), [&](std::size_t i) { return nearby_ranges(corrected_[i]); });
    calibrated_.world_from_view = poses_;
    calibrated_.centre = common_centre(registration::pointers_to(surfaces_), poses_);
    double spacing = 0.0;
    for (const ViewSurface& surface : surfaces_) spacing = std::max(spacing, surface.spacing());
    CalibrationSumOptions options;
    options.search = search_options();
    options.samples = static_cast<std::size_t>(options_.samples);
    options.patch = kPatch * spacing;
    return sum_pairs(calibrated_, pairs_, options);
  }

  CorrespondenceOptions search_options() const {
    double spacing = 0.0, noise = 0.0;
    for (const ViewSurface& surface : surfaces_) {
      spacing = std::max(spacing, surface.spacing());
      noise = std::max(noise, surface.noise());
    }
    CorrespondenceOptions search;
    search.max_distance = finest_search_distance(spacing, std::sqrt(2.0) * noise);
    search.max_normal_angle_deg = align_.refinement.max_normal_angle_deg;
    search.association = align_.refinement.association;
    return search;
  }

  static double median_deviation(const std::vector<PairSums>& sums) {
    std::vector<double> deviations;
    for (const PairSums& pair : sums)
      if (pair.deviation > 0.0) deviations.push_back(pair.deviation);
    return quantile(deviations, 0.5);
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
    for (std::size_t p = 0; p < model_.parameters.size(); ++p) {
      model_.parameters[p].value += found.errors[p];
      largest = std::max(largest, std::abs(found.errors[p]));
    }
    const auto before = poses_;
    for (std::size_t i = 0; i < held_.size(); ++i)
      if (!found.tangents[i].isZero(0.0))
        poses_[i] = moved(before[i], found.tangents[i], calibrated_.centre);
    const double motion = largest_motion(registration::pointers_to(surfaces_), before, poses_);
    return largest > kTolerance || motion > kTolerance * sensors_.models.front().spacing();
  }

  void describe(const HeldOutFit& fit) {
    const std::vector<double> deviations = jackknife_deviations(fit);
    ErrorModel deviation = model_;
    for (std::size_t p = 0; p < deviations.size(); ++p)
      deviation.parameters[p].value = deviations[p];
    for (std::size_t i = 0; i < given_.size(); ++i)
      result_.views.push_back({sensors_.of_view[i], model_.coefficients(i, sensors_),
                               deviation.coefficients(i, sensors_)});
    describe_errors(sensors_, model_, deviation, result_);
  }

  // The last steps of aligning, with all samples of the corrected views.
  Result<void> align_corrected() {
    if (const auto prepared = prepare(true); !prepared) return prepared;
    std::vector<ViewRole> roles;
    for (std::size_t i = 0; i < given_.size(); ++i)
      roles.push_back(!aligned_.views[i].aligned           ? ViewRole::kExcluded
                      : given_[i].pose == PoseKind::kKnown ? ViewRole::kFixed
                                                           : ViewRole::kFree);
    JointRefinementOptions options = align_.refinement;
    options.levels = 1;
    auto refined = refine_jointly(surfaces_, poses_, roles, options, {});
    if (!refined) return refined.error();
    result_.alignment = aligned_;
    Alignment& alignment = result_.alignment;
    for (std::size_t i = 0; i < given_.size(); ++i) {
      ViewReport& view = alignment.views[i];
      view.world_from_view = refined->world_from_view[i];
      view.pose_covariance =
          inflation_[i].asDiagonal() * refined->pose_covariance[i] * inflation_[i].asDiagonal();
      view.pose_std = inflation_[i].cwiseProduct(refined->pose_std[i]);
    }
    alignment.pairs = std::move(refined->pairs);
    alignment.termination = refined->termination;
    alignment.iterations += result_.iterations + refined->iterations;
    alignment.rms = refined->rms;
    alignment.loops = std::move(refined->loops);
    for (const auto* solves : {&solves_, &refined->solves})
      alignment.solves.insert(alignment.solves.end(), solves->begin(), solves->end());
    return {};
  }

  // The views as given and as corrected, by the same measure: distances along the lines of sight,
  // which no motion of the surfaces makes shorter by turning them away, and overlap that stays.
  bool fits_better() {
    const PairwiseFit corrected =
        measure_fit(surfaces_, result_.alignment.world_from_view(), pairs_, search_options());
    surfaces_.clear();
    for (const RangeView& view : given_) surfaces_.emplace_back(view, align_.surface);
    const PairwiseFit given =
        measure_fit(surfaces_, aligned_.world_from_view(), pairs_, search_options());
    return corrected.overlap >= kLeastOverlap * given.overlap &&
           corrected.distance < given.distance;
  }

  const std::vector<RangeView>& given_;
  const Alignment& aligned_;
  AlignOptions align_;
  CalibrationOptions options_;
  const Progress& progress_;
  std::vector<ViewPair> pairs_;
  std::vector<bool> held_;
  Sensors sensors_;
  std::vector<RigidMotion> poses_;
  ErrorModel model_;
  std::vector<RangeView> corrected_;
  std::vector<ViewSurface> surfaces_;
  CalibratedViews calibrated_;
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
  return run_in(
      context, [&] { return Calibrating(views, aligned, align, options, context.progress).run(); });
}

void apply_calibration(const SensorCalibration& calibration, std::vector<RangeView>& views) {
  if (!calibration.found()) return;
  const Sensors sensors = find_sensors(pointers_to(views), spacings_of(views));
  views = parallel_map<RangeView>(views.size(), [&](std::size_t i) {
    return sensors.models[sensors.of_view[i]].corrected(views[i],
                                                        calibration.views[i].coefficients);
  });
  apply_alignment(calibration.alignment, views);
}

}  // namespace relief::registration
