#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "relief/scan/camera.h"

namespace relief {

/// A family of rays over a plane of two coordinates, with which a cloud is seen.
struct CloudRays {
  enum class Kind {
    kParallel,   ///< Coordinates are lengths across the rays [unit].
    kPinhole,    ///< Coordinates are x / z and y / z; rays come from `origin`.
    kSpherical,  ///< Coordinates are azimuth and elevation downwards [rad], about -y.
  };

  Kind kind = Kind::kParallel;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< Columns x right, y down, z along.

  /// The two coordinates of a point and, third, its distance along the ray [unit].
  Eigen::Vector3d project(const Eigen::Vector3d& point) const;

  /// The direction of the ray of two coordinates, of unit length; in a pinhole picture of unit
  /// depth, so that ranges are depths, which is what cameras round.
  Eigen::Vector3d direction(const Eigen::Vector2d& at) const;

  /// How long a step of one in the coordinates is at a point [unit].
  double scale(double distance) const { return kind == Kind::kParallel ? 1.0 : distance; }
};

/// Parallel rays along `direction`; the picture is upright with respect to +y, else to +z.
CloudRays parallel_rays(const Eigen::Vector3d& direction, const Eigen::Vector3d& centre);

/// Rays from `viewpoint` towards the points: a pinhole picture along z or against it, as cameras
/// have it, where the points lie within 50 degrees of that, but for a thousandth that lie
/// within 75. Else one along x or against it where they lie so, as robots have it, with z upwards.
/// Points within 75 degrees, too, where they stand in rows and columns of that picture. Else one
/// along their mean direction where they lie within 50 degrees, else a spherical one: about y where
/// the points lie along z within 75 degrees, else about +z, its seam where the fewest points are.
CloudRays rays_from(const Eigen::Vector3d& viewpoint, const std::vector<Eigen::Vector3d>& points);

/// Whether the points lie all around the origin of `rays`, which rays_from() made for them: in all
/// but a twentieth of the directions about +z, and not in a cone before it.
bool surround(const std::vector<Eigen::Vector3d>& points, const CloudRays& rays);

/// A regular grid in the plane of the rays' coordinates: place (u, v) is
/// origin + u step_u + v step_v.
struct CloudLattice {
  int width = 0, height = 0;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  Eigen::Vector2d step_u = Eigen::Vector2d::UnitX(), step_v = Eigen::Vector2d::UnitY();

  Eigen::Vector2d at(double u, double v) const { return origin + u * step_u + v * step_v; }
};

/// The camera of these rays at the places of a grid. Parallel rays start so that a point at
/// `nearest` along them [unit] has a range of `standoff`.
Camera camera_of(const CloudRays& rays, const CloudLattice& lattice, double nearest,
                 double standoff);

}  // namespace relief
