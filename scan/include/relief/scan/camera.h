#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "relief/scan/projections.h"

namespace relief {

/// Focal lengths and principal point in pixels; integer coordinates are pixel centres.
struct PinholeIntrinsics {
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;
};

/// The rays of a sensor, equation (V1): sample (u, v) is P(t) = o(u,v) + t d(u,v) in the view
/// frame. Cheap to copy: a ray table is shared.
class Camera {
 public:
  enum class Model { kPinhole, kPinholeGl, kOrthographic, kSpherical, kRayTable };

  Camera() = default;

  /// Frame x right, y down, z forward: o = 0, d = [(u-cx)/fx, (v-cy)/fy, 1], t = z.
  static Camera pinhole(int width, int height, const PinholeIntrinsics& intrinsics);

  /// The convention of `.fc` files: P = [-(u-cx) Z/fx, -(v-cy) Z/fy, Z] with Z negative in front of
  /// the sensor; here d = [(u-cx)/fx, (v-cy)/fy, -1] and t = -Z.
  static Camera pinhole_gl(int width, int height, const PinholeIntrinsics& intrinsics);

  /// o = origin + u step_u + v step_v, d constant.
  static Camera orthographic(int width, int height, const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& step_u, const Eigen::Vector3d& step_v,
                             const Eigen::Vector3d& direction);

  /// A scanner that turns round the z axis of its frame: o = 0, |d| = 1, t = distance. The angles
  /// must be valid.
  static Camera spherical(SphericalProjection angles);

  /// Any sensor. `projection` maps points to pixels when the sensor has such a map.
  static Camera ray_table(Grid<Ray> rays, std::optional<RationalProjection> projection);
  static Camera ray_table(Grid<Ray> rays, SphericalProjection projection);

  Model model() const { return model_; }
  int width() const { return width_; }
  int height() const { return height_; }
  const PinholeIntrinsics& intrinsics() const { return intrinsics_; }

  /// The ray of a pixel inside the grid.
  Ray ray(int u, int v) const;

  /// The ray through fractional pixel coordinates; for a ray table, bilinear in origins and
  /// directions, the coordinates clamped to the grid. A spherical camera interpolates its angles.
  Ray ray_at(double u, double v) const;

  /// Fractional pixel coordinates of a point in the view frame, possibly outside the grid. Nothing
  /// when the point lies behind the sensor or the sensor has no projection.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;
  bool can_project() const {
    return model_ != Model::kRayTable || projection_.has_value() || spherical_;
  }

  /// The camera with pixels so many times as wide and high, of which the first covers the first
  /// ones here; pixels that fill none of these are left out. Nothing for a table of rays, for
  /// factors below 2, or where fewer than two rows or columns are left.
  std::optional<Camera> binned(int factor) const;

  /// The map of a table of rays, where it has one of this kind.
  const std::optional<RationalProjection>& projection() const { return projection_; }
  /// The angles of a spherical camera, or of a table of rays that is nearly one; else null.
  const SphericalProjection* spherical_projection() const { return spherical_.get(); }

 private:
  Model model_ = Model::kPinhole;
  int width_ = 0, height_ = 0;
  PinholeIntrinsics intrinsics_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d step_u_ = Eigen::Vector3d::Zero(), step_v_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_ = Eigen::Vector3d::UnitZ();
  std::shared_ptr<const Grid<Ray>> table_;
  std::optional<RationalProjection> projection_;
  std::shared_ptr<const SphericalProjection> spherical_;
};

/// `pinhole`, `pinhole_gl`, `orthographic`, `spherical` or `ray table`.
std::string_view to_string(Camera::Model model);

}  // namespace relief
