#pragma once

#include <cstddef>
#include <cstdint>

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "scan/background/depth_stack.h"
#include "scan/background/fixed_surface.h"

namespace relief {

/// What stands still before one camera.
struct CameraBackground {
  Camera camera;
  double range = 0.0;      ///< For same_rays().
  Grid<float> tolerance;   ///< As in DepthStack.
  FixedSurface surface;    ///< All that stands still.
  Grid<float> background;  ///< The depth of what of it is background [unit]; NaN: nothing is.
};

/// 1 for the samples of a view that belong to the background. These are the samples on it, what few
/// views know more of and that is continuous with it or lies on its plane, and specks that noise
/// cut off from it. `depths`, along the rays of the camera, and `edges` are those of that view.
Grid<std::uint8_t> mark_background(const CameraBackground& known, const Grid<float>& depths,
                                   const GridEdges& edges);

}  // namespace relief
