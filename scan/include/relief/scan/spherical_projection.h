#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "relief/scan/ray.h"

namespace relief {

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

struct SphericalProjectionFit {
  SphericalProjection projection;
  double rms_pixels = 0.0;  ///< See SphericalProjection::rms_pixels.
};

/// The angles of a grid of points: of each column and row the median of its points' angles; even
/// angles where they explain the points as well. Columns and rows without points get angles between
/// their neighbours'. Nothing when the angles do not grow or fall strictly, or when fewer than two
/// columns or rows have points.
std::optional<SphericalProjectionFit> fit_spherical_projection(const Grid<Eigen::Vector3d>& points);

}  // namespace relief
