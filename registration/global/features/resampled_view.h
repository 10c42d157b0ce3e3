#pragma once

#include <vector>

#include <Eigen/Core>

#include "registration/surface/view_surface.h"

namespace relief::registration {

/// A view thinned out to points about one `cell` apart: what coarse alignment looks at.
struct ResampledView {
  Eigen::Matrix3Xd points;   ///< View frame [unit].
  Eigen::Matrix3Xd normals;  ///< Unit, towards the sensor.

  Eigen::Index size() const { return points.cols(); }
};

/// The lengths that coarse alignment works with, the same for all views.
struct CoarseScale {
  double radius = 0.0;  ///< Of a typical view: nine in ten of its samples lie within [unit].
  double cell = 0.0;    ///< Side of the cells that views are resampled to [unit].
};

/// From the views that have samples: cells so large that a typical view has about two thousand, but
/// at least three sample spacings. Zero where no view has samples.
CoarseScale coarse_scale(const std::vector<ViewSurface>& surfaces);

/// One point per cubic cell of side `cell` [unit] > 0: the mean of its samples and their normals.
/// Cells that hold surfaces of different directions, as thin sheets do, are left out.
ResampledView resample(const ViewSurface& surface, double cell);

}  // namespace relief::registration
