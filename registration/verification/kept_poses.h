#pragma once

#include <vector>

#include "registration/posegraph/joint/joint_refinement.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/align_options.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Free views that refining moved away from the views they overlapped at their given poses: less
/// than half of that overlap is left, with whichever views. Refining goes where distances are
/// small; of few or coarse samples that may be where hardly any are left to compare.
std::vector<bool> lost_views(const std::vector<ViewSurface>& surfaces,
                             const std::vector<RigidMotion>& given,
                             const std::vector<RigidMotion>& refined,
                             const std::vector<ViewRole>& roles, Association association);

/// Free views that refining laid on each other as if they were seen from one place, from given
/// poses that were farther apart than it looks for partners. What stands still before the sensor
/// does so, and a body of revolution, which shares most when seen within the same outline.
std::vector<bool> views_laid_on_each_other(const std::vector<ViewSurface>& surfaces,
                                           const std::vector<RigidMotion>& given,
                                           const std::vector<RigidMotion>& refined,
                                           const std::vector<ViewRole>& roles,
                                           Association association);

/// Whether the views fit each other as well at their given poses as where refining moved them: they
/// share as much, and neither the RMS of their distances nor its coherent part falls by more than
/// samples tell. Then what moved them are errors that neighbouring samples share.
bool fit_as_well_as_refined(const std::vector<ViewSurface>& surfaces,
                            const std::vector<RigidMotion>& given,
                            const std::vector<RigidMotion>& refined,
                            const std::vector<ViewRole>& roles, Association association);

}  // namespace relief::registration
