#include "scan/simulation/objects/analytic_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace relief::simulation {

namespace {

// The arc lengths at which a line with unit direction enters and leaves a sphere round the origin.
std::optional<std::pair<double, double>> clip_to_sphere(const Ray& ray, double radius) {
  const double middle = -ray.origin.dot(ray.direction);
  const double half_squared = radius * radius - ray.at(middle).squaredNorm();
  if (half_squared <= 0.0) return std::nullopt;
  const double half = std::sqrt(half_squared);
  return std::pair{middle - half, middle + half};
}

// Newton's method along the ray, kept inside a bracket that always holds the sign change.
double polish_root(const AnalyticSurface& surface, const Ray& ray, double outside, double inside) {
  const double tolerance = 1e-14 * surface.bounding_radius;
  double s = 0.5 * (outside + inside);
  for (int iteration = 0; iteration < 60 && inside - outside > tolerance; ++iteration) {
    const Eigen::Vector3d point = ray.at(s);
    const double value = surface.value(point);
    (value > 0.0 ? outside : inside) = s;
    const double slope = surface.gradient(point).dot(ray.direction);
    if (std::abs(value) <= -slope * tolerance) return s;
    const double next = s - value / slope;
    s = next > outside && next < inside ? next : 0.5 * (outside + inside);
  }
  return s;
}

}  // namespace

AnalyticSurface sphere_surface(double radius) {
  AnalyticSurface surface;
  surface.value = [radius](const Eigen::Vector3d& p) { return p.norm() - radius; };
  surface.gradient = [](const Eigen::Vector3d& p) -> Eigen::Vector3d { return p.normalized(); };
  // A little more than the radius, so that rays start outside.
  surface.bounding_radius = 1.01 * radius;
  return surface;
}

Eigen::Vector3d unit_normal(const AnalyticSurface& surface, const Eigen::Vector3d& point) {
  return surface.gradient(point).normalized();
}

std::optional<double> intersect(const AnalyticSurface& surface, const Ray& ray) {
  const double scale = ray.direction.norm();
  const Ray unit_ray{ray.origin, ray.direction / scale};
  const auto span = clip_to_sphere(unit_ray, surface.bounding_radius);
  if (!span) return std::nullopt;

  // Sphere tracing (Hart 1996) with over-relaxation (Keinert et al. 2014): a step may be longer
  // than the free distance as long as the free spheres of its two ends touch. The least step ends
  // the slow approach to the surface; the bracket it leaves is so short that its first root is the
  // only one.
  const double least_step = 1e-4 * surface.bounding_radius, relaxed = 1.3;
  double s = std::max(0.0, span->first), factor = relaxed;
  double free = surface.value(unit_ray.at(s)) / surface.lipschitz;
  if (free <= 0.0) return std::nullopt;
  while (s < span->second) {
    const double step = std::max(factor * free, least_step);
    const double next_free = surface.value(unit_ray.at(s + step)) / surface.lipschitz;
    if (step > least_step && factor > 1.0 && free + next_free < step) {
      factor = 1.0;  // a gap between the spheres: take the safe step instead
      continue;
    }
    if (next_free <= 0.0) return polish_root(surface, unit_ray, s, s + step) / scale;
    s += step;
    free = next_free;
    factor = relaxed;
  }
  return std::nullopt;
}

}  // namespace relief::simulation
