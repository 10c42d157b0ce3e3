#pragma once

#include <optional>

#include <Eigen/Core>

#include "relief/scan/camera.h"
#include "relief/scan/projections.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief {

/// The pixel of a point in a view, for every sensor: by the camera's own projection, or, where it
/// is only a table of rays, by a projection fitted to the samples and refined on the rays.
class ViewProjection {
 public:
  /// kUnsolvable where the camera is a table without a projection and the samples of the view are
  /// too few to fit one.
  static Result<ViewProjection> create(const RangeView& view);

  /// Fractional pixel coordinates of a point in the view frame, possibly outside the grid. Nothing
  /// when the point lies behind the sensor.
  std::optional<Eigen::Vector2d> pixel_of(const Eigen::Vector3d& point_in_view) const;

  /// The smaller distance between the rays of neighbouring pixels at a point of the view frame that
  /// projects to (u, v) [unit].
  double pixel_footprint(const Eigen::Vector3d& point_in_view, double u, double v) const;

 private:
  Camera camera_;
  std::optional<RationalProjection> guess_;  // for cameras without a projection of their own
};

}  // namespace relief
