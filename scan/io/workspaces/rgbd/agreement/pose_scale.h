#pragma once

#include "scan/io/project/view_spec.h"
#include "scan/io/workspaces/rgbd/agreement/pose_agreement.h"

namespace relief {

/// Multiplies the translations of the poses by the factor at which the depth maps agree best, where
/// that is far better than as given (kFarBetter), with a note: poses from images alone, as COLMAP
/// finds them, have no scale. Nothing changes where the maps agree as depth cameras do, or agree
/// about as well from one place.
void take_pose_scale(ProjectSpec& project, const ComparedDepths& compared);

}  // namespace relief
