#pragma once

#include <vector>

#include <Eigen/Core>

#include "relief/scan/camera.h"
#include "relief/scan/grid.h"

namespace relief {

/// RMS residual of a camera's projection up to which it is right [pixels]: more names the pixel
/// beside.
inline constexpr double kGoodProjectionPixels = 0.5;

/// The points of a grid and the pixels where they lie.
struct GridSamples {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< Of the points.
};

/// The finite points, row by row.
GridSamples collect_samples(const Grid<Eigen::Vector3d>& points);

/// Median distance of samples from those `du` columns and `dv` rows beside them [unit of the
/// points]; 0 where there are none.
double median_distance_beside(const Grid<Eigen::Vector3d>& points, int du, int dv);

/// A camera with a formula, as a ratio of affine functions.
RationalProjection projection_of(const Camera& camera);

/// How far the projection sees the samples from their pixels, RMS; infinite where it cannot see
/// one.
double rms_pixels(const GridSamples& samples, const RationalProjection& projection);

}  // namespace relief
