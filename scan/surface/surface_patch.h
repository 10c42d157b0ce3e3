#pragma once

#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Core>

namespace relief {

/// A place between four samples of a grid, and what each of them counts for there.
struct SurfaceQuad {
  int u = 0, v = 0;  ///< The first sample; the others are right of it, below it, and both.
  std::array<double, 4> shares;  ///< Bilinear, row by row; their sum is 1.

  /// Nothing where the pixel is not between samples of a grid of this size.
  static std::optional<SurfaceQuad> at(const Eigen::Vector2d& pixel, int width, int height) {
    if (!(pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() < width - 1 && pixel.y() < height - 1))
      return std::nullopt;
    const int u = static_cast<int>(pixel.x()), v = static_cast<int>(pixel.y());
    const double a = pixel.x() - u, b = pixel.y() - v;
    return SurfaceQuad{u, v, {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b}};
  }
};

/// The surface at a place between four samples, which are its corners: the chord between them, bent
/// by their normals. On a curved surface the chord errs to one side and the tangent planes of the
/// corners err by the same amount to the other; the mean of both is exact to second order. Noise of
/// the corners' positions cancels in the bend.
struct SurfacePatch {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< What `chord` is relative to.
  Eigen::Vector3d chord = Eigen::Vector3d::Zero();   ///< Mean of the corners.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< Mean of those of the corners, unit.
  /// Mean over the corners of normal . corner, divided by the length of the mean normal.
  double tangent_offset = 0.0;
  double weight = 0.0;  ///< Mean of those of the corners.

  /// Signed distance of a point from the surface, positive in front of it: equation (F1).
  double distance(const Eigen::Vector3d& point) const {
    return normal.dot(point - origin) - 0.5 * (normal.dot(chord) + tangent_offset);
  }
  /// The point of the surface at the chord's.
  Eigen::Vector3d point() const {
    return origin + chord - 0.5 * (normal.dot(chord) - tangent_offset) * normal;
  }

  /// Takes the sums over the corners for `normal` and `tangent_offset`, and makes the means of
  /// them. False where the normals have no mean.
  bool normalize() {
    constexpr double kLeastLength = 0.1;  // Of a mean of normals within 84 degrees of each other.
    const double length = normal.norm();
    if (!(length > kLeastLength)) return false;
    normal /= length;
    tangent_offset /= length;
    return true;
  }
};

}  // namespace relief
