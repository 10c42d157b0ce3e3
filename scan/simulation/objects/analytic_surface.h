#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>

#include "relief/scan/projections.h"

namespace relief::simulation {

/// A closed surface known exactly: the zero set of a smooth implicit function, negative inside.
/// Lengths are in the unit of the object.
struct AnalyticSurface {
  std::function<double(const Eigen::Vector3d&)> value;  ///< [unit]
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> gradient;
  double bounding_radius = 0.0;  ///< The surface lies within this distance of the origin [unit].
  /// Bound of |gradient| outside the surface and within the bounding radius: `value / lipschitz` is
  /// a distance that a ray can advance without crossing the surface.
  double lipschitz = 1.0;
};

/// A sphere round the origin.
AnalyticSurface sphere_surface(double radius);

/// The unit outward normal at a point of the surface.
Eigen::Vector3d unit_normal(const AnalyticSurface& surface, const Eigen::Vector3d& point);

/// The smallest range t > 0 at which `ray` enters the surface, with an error of the point below
/// 1e-12 of the bounding radius where the ray is not tangent. A ray that grazes the inside for less
/// than 1e-4 of the bounding radius may pass as a miss. Rays starting inside give nothing.
std::optional<double> intersect(const AnalyticSurface& surface, const Ray& ray);

}  // namespace relief::simulation
