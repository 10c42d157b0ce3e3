#include "tests/fusion/scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace relief::testing {

SignedDistance sphere_distance(double radius) {
  return [=](const Eigen::Vector3d& p) { return p.norm() - radius; };
}

SignedDistance torus_distance(double major_radius, double minor_radius) {
  return [=](const Eigen::Vector3d& p) {
    return std::hypot(p.head<2>().norm() - major_radius, p.z()) - minor_radius;
  };
}

SignedDistance box_distance(const Eigen::Vector3d& half_sizes) {
  return [=](const Eigen::Vector3d& p) {
    const Eigen::Vector3d beyond = p.cwiseAbs() - half_sizes;
    return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
  };
}

Surface traced(SignedDistance distance) {
  return [=](const Ray& ray) -> std::optional<SurfaceHit> {
    const double speed = ray.direction.norm();
    double t = 0.0;
    for (int step = 0; step < 500; ++step) {
      const Eigen::Vector3d p = ray.at(t);
      const double d = distance(p);
      if (d > 1e4) break;
      t += d / speed;
      if (d > 1e-9) continue;
      Eigen::Vector3d normal;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d h = 1e-5 * Eigen::Vector3d::Unit(k);
        normal[k] = distance(p + h) - distance(p - h);
      }
      return SurfaceHit{t, normal.normalized()};
    }
    return std::nullopt;
  };
}

std::vector<Eigen::Vector3d> even_directions(int count) {
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / count, r = std::sqrt(1.0 - z * z);
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return directions;
}

std::vector<RangeView> views_around(const Surface& surface, int count, int size, double radius) {
  const double away = 6.0 * radius, centre = 0.5 * (size - 1);
  const double focal = 0.5 * size * away / (1.1 * radius);
  std::vector<RangeView> views;
  for (const Eigen::Vector3d& direction : even_directions(count)) {
    views.push_back(render(surface, Camera::pinhole(size, size, {focal, focal, centre, centre}),
                           look_at(away * direction, Eigen::Vector3d::Zero())));
    views.back().name = "view" + std::to_string(views.size() - 1);
  }
  return views;
}

std::vector<NodeKey> cube_of_blocks(int side) {
  std::vector<NodeKey> blocks;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) blocks.push_back(key_of({x, y, z}));
  make_sorted_set(blocks);
  return blocks;
}

}  // namespace relief::testing
