#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "relief/scan/projections.h"

namespace relief {

struct RationalProjectionFit {
  RationalProjection projection;
  double rms_pixels = 0.0;  ///< RMS of the distance between the given and the projected pixels.
};

/// Least-squares fit to `points` (view frame) seen at `pixels`. Nothing when fewer than 12 points
/// are given or they do not determine the map (all in one plane).
std::optional<RationalProjectionFit> fit_rational_projection(
    const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector2d>& pixels);

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
