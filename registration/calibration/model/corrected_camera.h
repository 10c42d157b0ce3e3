#pragma once

#include <Eigen/Core>

#include "relief/registration/calibrate_views.h"
#include "relief/scan/camera.h"
#include "relief/scan/range_view.h"

namespace relief::registration {

/// What the calibration of a camera has wrong, in units of its own.
struct CameraCorrection {
  double log_focal = 0.0;   ///< Logarithm of the true focal lengths over the given ones.
  double log_aspect = 0.0;  ///< The same for fx, and its negative for fy.
  Eigen::Vector2d principal_point = Eigen::Vector2d::Zero();  ///< True minus given [pixels].
  Eigen::Vector2d radial = Eigen::Vector2d::Zero();      ///< k1 and k2 that undo the distortion.
  Eigen::Vector2d tangential = Eigen::Vector2d::Zero();  ///< p1 and p2 that undo the distortion.
  double interlacing =
      0.0;  ///< How much farther even rows lie along themselves than odd ones [pixels].

  /// Adds the parameter `index` of an error; those of ranges change nothing.
  void add(SensorError error, int index, double value);

  bool moves_intrinsics() const;
  bool distorts() const { return !radial.isZero(0.0) || !tangential.isZero(0.0); }
};

/// The camera of a view without these errors. A pinhole camera stays one unless it is distorted,
/// which makes it a table of rays with a projection that fits the samples of the view.
Camera corrected_camera(const RangeView& view, const CameraCorrection& correction);

/// What one column more moves the point at a range by, about a pixel [unit].
Eigen::Vector3d column_step(const Camera& camera, const Eigen::Vector2d& pixel, double range);

}  // namespace relief::registration
