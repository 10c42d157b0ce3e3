#pragma once

#include <cstddef>
#include <vector>

#include "registration/surface/view_surface.h"
#include "registration/units/align_units.h"
#include "relief/registration/align_options.h"
#include "relief/registration/align_views.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::registration {

/// align_views() of views whose surfaces are made, without what errors of the sensors add to the
/// covariances of poses. The only error is kInterrupted.
Result<Alignment> align_surfaces(const std::vector<RangeView>& views,
                                 const std::vector<ViewSurface>& surfaces,
                                 const AlignOptions& options, const Progress& progress = {},
                                 const AlignUnits& units = {});

/// How many views are PoseStatus::kVerified.
std::size_t verified_views(const Alignment& alignment);

}  // namespace relief::registration
