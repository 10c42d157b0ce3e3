#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "registration/given_poses/checked_poses.h"
#include "registration/global/view_groups.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/align_options.h"
#include "relief/scan/range_view.h"

namespace relief::registration {

/// Why a view of `placed` got no pose, and what to do: what is known of the best pose that was
/// found but not believed, and what it lacks.
std::string unplaced_reason(std::size_t view, const ViewGroups& placed, const CheckedPoses& checked,
                            const std::vector<RangeView>& views,
                            const std::vector<ViewSurface>& surfaces,
                            const StartingPoseOptions& options);

/// `35 %`.
std::string in_percent(double fraction);

}  // namespace relief::registration
