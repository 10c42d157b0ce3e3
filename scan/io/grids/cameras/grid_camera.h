#pragma once

#include "relief/scan/camera.h"
#include "relief/scan/grid.h"

namespace relief {

/// A camera for points that a file gives on a grid.
struct GridCamera {
  Camera camera;
  Grid<double> range;        ///< Of each sample on its ray; NaN where there is none.
  double rms_pixels = 0.0;   ///< Of the camera's projection of the samples to their pixels.
  bool exact_model = false;  ///< The model's own rays pass through all points.
};

/// Puts points on the rays of `model`. Where they all lie on them (to a thousandth of the sample
/// spacing), the camera is `model` itself; else it is a table of the model's rays, each shifted
/// sideways through its own point, so that no point is changed. A table gets a projection if one
/// is found that meets the samples' pixels to half a pixel RMS.
GridCamera camera_through_points(const Grid<Eigen::Vector3d>& points, const Camera& model);

}  // namespace relief
