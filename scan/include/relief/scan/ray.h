#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace relief {

/// The line of points that one pixel can measure: P(t) = origin + t direction, in the view frame.
/// `t` (the range) grows away from the sensor. The direction need not be a unit vector.
struct Ray {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();

  Eigen::Vector3d at(double t) const { return origin + t * direction; }

  /// The range of the point of the ray closest to `point`.
  double range_of(const Eigen::Vector3d& point) const {
    return (point - origin).dot(direction) / direction.squaredNorm();
  }
};

}  // namespace relief
