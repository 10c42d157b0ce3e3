#pragma once

#include <vector>

#include "registration/joint_refinement.h"
#include "registration/pose_verification.h"
#include "registration/starting_poses.h"
#include "registration/view_surface.h"
#include "scan/progress.h"
#include "scan/range_view.h"
#include "scan/result.h"

namespace relief {

/// The poses that views came with, refined together before they are judged: poses a few spacings
/// off, as other programs and turntables give them, contradict each other until they are refined.
struct RefinedGivenPoses {
  SettledPoses settled;
  JointRefinement refined;    ///< Of the given poses that were not refuted.
  PoseVerification verified;  ///< Of the same, at the refined poses.
};

/// Refines the given poses jointly and verifies them; views that the others refute are taken out,
/// unless the user trusts them, and the rest is refined again without them. The only error is
/// kInterrupted.
Result<RefinedGivenPoses> refine_given_poses(const std::vector<ViewSurface>& surfaces,
                                             const std::vector<RangeView>& views,
                                             const StartingPoseOptions& options,
                                             const JointRefinementOptions& refinement,
                                             const Progress& progress = {});

/// What a pose must show of the set's own errors: see verify_poses().
PoseVerificationOptions verification_options(const StartingPoseOptions& options);

}  // namespace relief
