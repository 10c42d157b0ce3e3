#include "registration/calibration/corrected_alignment.h"

#include <utility>

#include "registration/posegraph/joint/joint_refinement.h"

namespace relief::registration {

namespace {

// Part of the overlap that must stay: chance and the borders of views take less than a twentieth.
constexpr double kLeastOverlap = 0.95;

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

PairwiseFit fit_of(const CorrectedViews& views, const std::vector<RigidMotion>& world_from_view,
                   const std::vector<ViewPair>& pairs) {
  return measure_fit(views.surfaces(), world_from_view, pairs,
                     finest_search(views.surfaces(), views.align().refinement));
}

bool fits_better(const PairwiseFit& now, const PairwiseFit& before) {
  return now.overlap >= kLeastOverlap * before.overlap && now.distance < before.distance;
}

}  // namespace relief::registration
