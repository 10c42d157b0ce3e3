#pragma once

#include <cstddef>
#include <vector>

#include "registration/given_poses/given_poses.h"
#include "registration/global/starting_poses.h"
#include "relief/registration/align_views.h"

namespace relief::registration {

/// How far an alignment came.
struct AlignmentState {
  StartingPoses starts;
  std::vector<ViewRole> roles;
  std::size_t frame = 0;        ///< Of `starts`, that of the result.
  std::vector<bool> taken_out;  ///< Views that shape placed, and that others contradict there.
  JointRefinement refined;
  PoseVerification verified;
};

/// Poses, status and reason of each view, and notes for the user.
Alignment report_alignment(const std::vector<RangeView>& views,
                           const std::vector<ViewSurface>& surfaces, GivenPoses given_poses,
                           const CheckedPoses& checked, const PoseConvention& convention,
                           AlignmentState state);

}  // namespace relief::registration
