#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>

#include "scan/ray.h"
#include "scan/triangle_mesh.h"

namespace relief {

/// A closed surface known exactly: the zero set of an implicit function, negative inside.
/// Units are those of the object.
struct AnalyticSurface {
  std::function<double(const Eigen::Vector3d&)> value;
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> gradient;
  double bounding_radius = 0.0;  ///< The surface lies within this distance of the origin.
  double step = 0.0;             ///< No feature along a ray is shorter than this.
};

/// The built-in object: a rounded body with fine relief (ridges, letters-like bumps, grooves), 100
/// mm across, millimetres, centred at the origin, closed, of genus 0.
AnalyticSurface built_in_object();

/// A sphere round the origin.
AnalyticSurface sphere_surface(double radius);

/// The smallest range t > 0 at which `ray` enters the surface, to 1e-12 of the bounding radius.
std::optional<double> intersect(const AnalyticSurface& surface, const Ray& ray);

}  // namespace relief
