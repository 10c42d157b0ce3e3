#pragma once

#include <cstddef>
#include <vector>

#include "registration/global/view_groups.h"
#include "registration/surface/view_surface.h"
#include "registration/verification/pose_evidence.h"

namespace relief::registration {

/// Links between views that follow each other (the first follows the last) and are not in one group
/// yet, as if the object had been turned between them: by 15 to 90 degrees or 360 over the number
/// of views, about axes up to 40 degrees off the sensor's vertical, or as between the nearest views
/// before and after whose motion is known. Links over one view between close loops with them. Only
/// those that fit, or may_be_right().
std::vector<PoseLink> turntable_links(const std::vector<ViewSurface>& surfaces,
                                      const ViewGroups& groups,
                                      const VerificationThresholds& limits,
                                      const JudgeOptions& judge);

}  // namespace relief::registration
