#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include <Eigen/Core>

#include "relief/scan/range_view.h"

namespace relief::testing {

/// A point of a surface and its unit outward normal.
struct SurfaceHit {
  double t = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// Where a ray of the world frame first meets a surface, if it does.
using Surface = std::function<std::optional<SurfaceHit>(const Ray& ray_in_world)>;

Surface plane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal);
Surface sphere(const Eigen::Vector3d& centre, double radius);

/// The exact view of `surface` from `camera` at `world_from_view`: range and true normals.
RangeView render(const Surface& surface, const Camera& camera,
                 const RigidMotion& world_from_view = RigidMotion::Identity());

/// The pose of a camera (x right, y down, z forward) at `eye` looking at `target`, with -y close to
/// `up`.
RigidMotion look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                    const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());

/// Adds white Gaussian noise of standard deviation `sigma` (length along the ray) to the range.
void add_range_noise(RangeView& view, double sigma, std::uint32_t seed);

/// Turns each normal by a Gaussian angle of `sigma_rad` about each of two axes of its tangent
/// plane.
void add_normal_noise(RangeView& view, double sigma_rad, std::uint32_t seed);

}  // namespace relief::testing
