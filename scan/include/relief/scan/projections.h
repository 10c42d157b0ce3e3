#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "relief/scan/grid.h"

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

/// A map from points to pixels whose two coordinates are each a ratio of affine functions,
///   u = (a . [P 1]) / (b . [P 1]),   v = (c . [P 1]) / (d . [P 1]).
/// Pinhole and orthographic cameras are special cases; so is the laser line scanner whose sensor
/// moves along one axis (u affine, v perspective: the linear pushbroom camera of Gupta and Hartley
/// 1997). The points of one pixel lie on the intersection of two planes: its ray.
struct RationalProjection {
  Eigen::Vector4d u_numerator = Eigen::Vector4d::Zero();
  Eigen::Vector4d u_denominator = Eigen::Vector4d::Zero();
  Eigen::Vector4d v_numerator = Eigen::Vector4d::Zero();
  Eigen::Vector4d v_denominator = Eigen::Vector4d::Zero();

  /// Pixel coordinates of a point of the view frame; nothing where a denominator vanishes or has
  /// the sign it does not have on the samples the projection was fitted to (behind the sensor).
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;

  /// The ray of a pixel. Its direction is a unit vector whose sign is that of `towards`; its origin
  /// is the point of the ray closest to the origin of the frame.
  Ray ray(double u, double v, const Eigen::Vector3d& towards) const;
};

/// The rays of a scanner that turns round an axis, as terrestrial laser scanners do. The sensor is
/// at the origin of the view frame, z is its axis, and the ray of pixel (u, v) is
///   d = [cos e_v cos a_u, cos e_v sin a_u, sin e_v],
/// with one azimuth a for each column and one elevation e for each row.
struct SphericalProjection {
  /// [rad], one for each column, strictly growing or falling, less than a turn (to a millionth)
  /// from the first to the last. At least two.
  std::vector<double> azimuth;
  /// [rad], one for each row, strictly growing or falling, in [-pi/2, pi/2]. At least two.
  std::vector<double> elevation;

  /// Even angles: those of pixel (0, 0), and the step from one pixel to the next.
  static SphericalProjection even(int width, int height, double azimuth, double azimuth_step,
                                  double elevation, double elevation_step);

  /// Whether the angles are as their comments demand.
  bool valid() const;

  /// The ray through fractional pixel coordinates. Its direction has length 1.
  Ray ray(double u, double v) const;

  /// Fractional pixel coordinates of a point of the view frame, possibly outside the grid: the
  /// azimuth is taken in the turn whose middle is that of the columns. Nothing for points on the
  /// axis.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;

  /// RMS of the distance [pixels] between the pixels of a grid's points and their projections.
  /// Infinity without points. Near the axis, where columns meet, those count by their width.
  double rms_pixels(const Grid<Eigen::Vector3d>& points) const;
};

}  // namespace relief
