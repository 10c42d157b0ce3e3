#include "registration/calibration/corrected_views.h"

#include <algorithm>
#include <cmath>

#include "registration/calibration/calibration_input.h"
#include "registration/pairwise/search_schedule.h"
#include "registration/posegraph/joint/joint_refinement.h"
#include "registration/posegraph/pose_step.h"
#include "registration/posegraph/refinement/pose_graph_refinement.h"
#include "registration/surface/view_surfaces.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Edge of the cubes that are in one fold as a whole [sample spacings], as of the clusters of (R12).
constexpr double kPatch = 8.0;

double largest_spacing(const std::vector<ViewSurface>& surfaces) {
  double spacing = 0.0;
  for (const ViewSurface& surface : surfaces) spacing = std::max(spacing, surface.spacing());
  return spacing;
}

}  // namespace

CorrespondenceOptions finest_search(const std::vector<ViewSurface>& surfaces,
                                    const JointRefinementOptions& refinement) {
  double noise = 0.0;
  for (const ViewSurface& surface : surfaces) noise = std::max(noise, surface.noise());
  CorrespondenceOptions search;
  search.max_distance = finest_search_distance(largest_spacing(surfaces), std::sqrt(2.0) * noise);
  search.max_normal_angle_deg = refinement.max_normal_angle_deg;
  search.association = refinement.association;
  return search;
}

CalibratedViews calibrated_views(const std::vector<RangeView>& given,
                                 const std::vector<RangeView>& measured,
                                 const std::vector<ViewSurface>& surfaces, const Sensors& sensors,
                                 const std::vector<RigidMotion>& world_from_view,
                                 const std::vector<ViewPair>& pairs) {
  CalibratedViews views;
  views.given = &given;
  views.surfaces = &surfaces;
  views.sensors = &sensors;
  const std::vector<bool> linked = linked_views(given.size(), pairs);
  views.nearby_ranges = parallel_map<Grid<double>>(given.size(), [&](std::size_t i) {
    return linked[i] ? nearby_ranges(measured[i]) : Grid<double>();
  });
  views.world_from_view = world_from_view;
  views.centre = common_centre(pointers_to(surfaces), world_from_view);
  return views;
}

CalibrationSumOptions sum_options(const std::vector<ViewSurface>& surfaces,
                                  const JointRefinementOptions& refinement, std::size_t samples) {
  CalibrationSumOptions options;
  options.search = finest_search(surfaces, refinement);
  options.samples = samples;
  options.patch = kPatch * largest_spacing(surfaces);
  return options;
}

Result<void> CorrectedViews::correct(const ErrorModel& model, bool with_normals,
                                     const Reporting& report) {
  surfaces_.clear();
  views_ = parallel_map<RangeView>(given_.size(), [&](std::size_t i) {
    const RangeView ranges = with_normals ? given_[i] : ranges_of(given_[i]);
    return model.choices.empty() ? ranges
                                 : sensors_.models[sensors_.of_view[i]].corrected(
                                       ranges, model.coefficients(i, sensors_));
  });
  ViewSurfaceOptions options = align_.surface;
  options.normal_signal &= with_normals;
  const auto make = [&](std::size_t i) {
    if (!noise_[i]) noise_[i] = estimate_range_noise(given_[i]);
    return ViewSurface(views_[i], *noise_[i], options);
  };
  auto surfaces = make_surfaces(given_.size(), make, report);
  if (!surfaces) return Error{ErrorKind::kInterrupted, "calibration was interrupted"};
  surfaces_ = *std::move(surfaces);
  return {};
}

std::vector<PairSums> CorrectedViews::sum(const std::vector<RigidMotion>& world_from_view,
                                          const std::vector<ViewPair>& pairs, std::size_t samples) {
  calibrated_ = calibrated_views(given_, views_, surfaces_, sensors_, world_from_view, pairs);
  return sum_pairs(calibrated_, pairs, sum_options(surfaces_, align_.refinement, samples));
}

}  // namespace relief::registration
