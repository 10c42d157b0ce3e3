#pragma once

#include <optional>
#include <vector>

#include "registration/given_poses/checked_poses.h"
#include "registration/given_poses/pose_convention.h"
#include "registration/posegraph/joint/joint_refinement.h"
#include "registration/surface/view_surface.h"
#include "registration/units/align_units.h"
#include "registration/verification/pose_verification.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::registration {

/// The poses that views came with, refined together before they are judged: poses a few spacings
/// off, as other programs and turntables give them, contradict each other until they are refined.
struct RefinedGivenPoses {
  CheckedPoses checked;
  JointRefinement refined;    ///< Of the given poses that were not refuted.
  PoseVerification verified;  ///< Of the same, at the refined poses.
  PoseConvention convention;  ///< In which the given poses were taken.
};

/// Known poses are fixed, guesses free unless they are ignored, and views without a pose excluded.
std::vector<ViewRole> roles_of(const std::vector<RangeView>& views, GivenPoses given);

/// `roles` with the `views` excluded.
std::vector<ViewRole> without_views(const std::vector<bool>& views, std::vector<ViewRole> roles);

/// Refines the given poses jointly and verifies them; views that the others refute are taken out,
/// unless the user trusts them, and the rest is refined again without them. Guesses are taken in
/// `convention`; without one in that of find_pose_convention() where more views confirm each other
/// then. The only error is kInterrupted.
Result<RefinedGivenPoses> refine_given_poses(const std::vector<ViewSurface>& surfaces,
                                             const std::vector<RangeView>& views,
                                             const StartingPoseOptions& options,
                                             const JointRefinementOptions& refinement,
                                             const std::optional<PoseConvention>& convention = {},
                                             const Progress& progress = {},
                                             const AlignUnits& units = {});

/// What a pose must show of the set's own errors: see verify_poses().
PoseVerificationOptions verification_options(const StartingPoseOptions& options);

}  // namespace relief::registration
