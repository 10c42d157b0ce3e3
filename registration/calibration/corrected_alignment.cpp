#include "registration/calibration/corrected_alignment.h"

#include <utility>

#include "registration/calibration/pairwise_fit.h"
#include "registration/posegraph/joint_refinement.h"

namespace relief::registration {

namespace {

// Part of the overlap that must stay: chance and the borders of views take less than a twentieth.
constexpr double kLeastOverlap = 0.95;

PairwiseFit fit_of(const std::vector<ViewSurface>& surfaces, const Alignment& alignment,
                   const std::vector<ViewPair>& pairs, const AlignOptions& align) {
  return measure_fit(surfaces, alignment.world_from_view(), pairs,
                     finest_search(surfaces, align.refinement));
}

}  // namespace

Result<Alignment> align_corrected(const CorrectedViews& views, const Alignment& given,
                                  const std::vector<RigidMotion>& start,
                                  const std::vector<RigidTangent>& inflation) {
  std::vector<ViewRole> roles;
  for (std::size_t i = 0; i < given.views.size(); ++i)
    roles.push_back(!given.views[i].aligned                     ? ViewRole::kExcluded
                    : views.given()[i].pose == PoseKind::kKnown ? ViewRole::kFixed
                                                                : ViewRole::kFree);
  JointRefinementOptions options = views.align().refinement;
  options.levels = 1;
  auto refined = refine_jointly(views.surfaces(), start, roles, options, {});
  if (!refined) return refined.error();
  Alignment alignment = given;
  for (std::size_t i = 0; i < given.views.size(); ++i) {
    ViewReport& view = alignment.views[i];
    view.world_from_view = refined->world_from_view[i];
    view.pose_covariance =
        inflation[i].asDiagonal() * refined->pose_covariance[i] * inflation[i].asDiagonal();
    view.pose_std = inflation[i].cwiseProduct(refined->pose_std[i]);
  }
  alignment.pairs = std::move(refined->pairs);
  alignment.termination = refined->termination;
  alignment.iterations += refined->iterations;
  alignment.rms = refined->rms;
  alignment.loops = std::move(refined->loops);
  alignment.solves.insert(alignment.solves.end(), refined->solves.begin(), refined->solves.end());
  return alignment;
}

bool fits_better(CorrectedViews& views, const Alignment& corrected, const Alignment& given,
                 const std::vector<ViewPair>& pairs) {
  const PairwiseFit after = fit_of(views.surfaces(), corrected, pairs, views.align());
  views.drop_surfaces();
  std::vector<ViewSurface> surfaces;
  for (const RangeView& view : views.given()) surfaces.emplace_back(view, views.align().surface);
  const PairwiseFit before = fit_of(surfaces, given, pairs, views.align());
  return after.overlap >= kLeastOverlap * before.overlap && after.distance < before.distance;
}

}  // namespace relief::registration
