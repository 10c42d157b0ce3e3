#pragma once

#include <vector>

#include "registration/surface/view_surface.h"
#include "registration/units/align_units.h"
#include "relief/registration/align_options.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::registration {

/// What every alignment of views begins with.
struct PreparedViews {
  std::vector<ViewSurface> surfaces;  ///< By view.
  AlignUnits units;                   ///< Of these surfaces.
};

/// How surfaces of views are made for such options.
ViewSurfaceOptions surface_options(const AlignOptions& options);

/// Errors: kBadInput for no views, impossible options, or a camera that cannot project where that
/// is asked for; kInterrupted. The views must outlive the surfaces.
Result<PreparedViews> prepare_to_align(const std::vector<RangeView>& views,
                                       const AlignOptions& options, const Context& context);

}  // namespace relief::registration
