#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/ray.h"

namespace relief {

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

struct RationalProjectionFit {
  RationalProjection projection;
  double rms_pixels = 0.0;  ///< RMS of the distance between the given and the projected pixels.
};

/// Least-squares fit to `points` (view frame) seen at `pixels`. Nothing when fewer than 12 points
/// are given or they do not determine the map (all in one plane).
std::optional<RationalProjectionFit> fit_rational_projection(
    const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector2d>& pixels);

}  // namespace relief
