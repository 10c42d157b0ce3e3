#pragma once

#include <optional>
#include <vector>

#include "registration/surface/view_surface.h"
#include "registration/units/align_units.h"
#include "relief/registration/align_options.h"
#include "relief/registration/align_views.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "scan/views/pose_convention.h"

namespace relief::registration {

struct AlignedOnce {
  Alignment alignment;
  PoseConvention convention;  ///< In which the guesses were taken.
};

/// From guesses to verified poses, without doubting guesses as a whole: align_surfaces() does.
/// Takes them in `convention`; without one in what find_pose_convention() says. The only error is
/// kInterrupted.
Result<AlignedOnce> align_once(const std::vector<RangeView>& views,
                               const std::vector<ViewSurface>& surfaces,
                               const AlignOptions& options, const AlignUnits& units,
                               const Progress& progress,
                               const std::optional<PoseConvention>& convention = {});

}  // namespace relief::registration
