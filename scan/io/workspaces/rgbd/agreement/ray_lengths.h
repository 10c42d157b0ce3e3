#pragma once

#include "scan/io/project/view_spec.h"
#include "scan/io/workspaces/rgbd/agreement/pose_agreement.h"

namespace relief {

/// Takes the depths of a project for distances along the rays where they agree far better so at
/// their poses (kFarBetter), with a note: many simulators write these, and files of depth maps do
/// not tell. Without poses depths stay what they are.
void take_ray_lengths(ProjectSpec& project, const ComparedDepths& compared);

}  // namespace relief
