#include "registration/calibration/corrected_alignment.h"

#include <algorithm>
#include <utility>

#include "registration/align_surfaces.h"
#include "registration/given_poses/given_poses.h"
#include "registration/given_poses/kept_poses.h"
#include "registration/posegraph/joint/joint_refinement.h"

namespace relief::registration {

namespace {

// Part of the overlap that must stay: chance and the borders of views take less than a twentieth.
constexpr double kLeastOverlap = 0.95;

void inflate(const std::vector<RigidTangent>& factors, Alignment& alignment) {
  for (std::size_t i = 0; i < factors.size(); ++i) {
    ViewReport& view = alignment.views[i];
    view.pose_covariance = factors[i].asDiagonal() * view.pose_covariance * factors[i].asDiagonal();
    view.pose_std = factors[i].cwiseProduct(view.pose_std);
  }
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
    view.pose_covariance = refined->pose_covariance[i];
    view.pose_std = refined->pose_std[i];
    view.sensor_covariance.setZero();
  }
  inflate(inflation, alignment);
  alignment.sensor_error.clear();
  alignment.pairs = std::move(refined->pairs);
  alignment.termination = refined->termination;
  alignment.iterations += refined->iterations;
  alignment.last_motion = refined->last_motion;
  alignment.rms = refined->rms;
  alignment.loops = std::move(refined->loops);
  alignment.solves.insert(alignment.solves.end(), refined->solves.begin(), refined->solves.end());
  return alignment;
}

Result<Alignment> align_from_given(const CorrectedViews& views, const Alignment& given,
                                   const std::vector<RigidTangent>& inflation,
                                   const Progress& progress) {
  auto alignment = align_surfaces(views.views(), views.surfaces(), views.align(), progress);
  if (!alignment) return alignment;
  inflate(inflation, *alignment);
  alignment->iterations += given.iterations;
  alignment->solves.insert(alignment->solves.begin(), given.solves.begin(), given.solves.end());
  return alignment;
}

bool may_gain_from_given(const CorrectedViews& views, const Alignment& given,
                         const Alignment& corrected) {
  const auto usable = static_cast<std::size_t>(std::ranges::count_if(
      views.surfaces(), [](const ViewSurface& surface) { return !surface.samples().empty(); }));
  if (verified_views(given) < usable) return true;
  const StartingPoseOptions& starting = views.align().starting_poses;
  if (!starting.keep_given) return false;
  std::vector<RigidMotion> poses;
  for (const RangeView& view : views.given()) poses.push_back(view.world_from_view);
  const auto roles = roles_of(views.given(), starting.given);
  const auto refined = corrected.world_from_view();
  return GivenAndRefined(views.surfaces(), poses, refined, roles, starting.association)
      .given_fit_as_well();
}

std::size_t aligned_views(const Alignment& alignment) {
  return static_cast<std::size_t>(std::ranges::count(alignment.views, true, &ViewReport::aligned));
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
