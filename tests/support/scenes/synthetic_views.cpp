#include "tests/support/scenes/synthetic_views.h"

#include <cmath>
#include <random>

#include <Eigen/Geometry>

namespace relief::testing {

Surface plane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  return [=](const Ray& ray) -> std::optional<SurfaceHit> {
    const double slope = ray.direction.dot(normal);
    if (slope == 0.0) return std::nullopt;
    return SurfaceHit{(point - ray.origin).dot(normal) / slope, normal.normalized()};
  };
}

Surface sphere(const Eigen::Vector3d& centre, double radius) {
  return [=](const Ray& ray) -> std::optional<SurfaceHit> {
    const Eigen::Vector3d from_centre = ray.origin - centre;
    const double a = ray.direction.squaredNorm(), b = ray.direction.dot(from_centre);
    const double discriminant = b * b - a * (from_centre.squaredNorm() - radius * radius);
    if (discriminant < 0.0) return std::nullopt;
    const double t = (-b - std::sqrt(discriminant)) / a;
    return SurfaceHit{t, (ray.at(t) - centre) / radius};
  };
}

RangeView render(const Surface& surface, const Camera& camera, const RigidMotion& world_from_view) {
  RangeView view;
  view.name = "synthetic";
  view.camera = camera;
  view.world_from_view = world_from_view;
  view.pose = PoseKind::kGuess;
  view.range = Grid<double>(camera.width(), camera.height(), kNoSample);
  view.normals = Grid<Eigen::Vector3f>(camera.width(), camera.height(),
                                       Eigen::Vector3f::Constant(static_cast<float>(kNoSample)));
  const RigidMotion view_from_world = world_from_view.inverse();
  for (int v = 0; v < camera.height(); ++v) {
    for (int u = 0; u < camera.width(); ++u) {
      const Ray ray = camera.ray(u, v);
      const Ray in_world{world_from_view * ray.origin, world_from_view.linear() * ray.direction};
      const auto hit = surface(in_world);
      if (!hit) continue;
      Eigen::Vector3d normal = view_from_world.linear() * hit->normal;
      if (normal.dot(ray.direction) > 0.0) normal = -normal;
      view.range(u, v) = hit->t;
      view.normals(u, v) = normal.cast<float>();
    }
  }
  return view;
}

RigidMotion look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                    const Eigen::Vector3d& up) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(up).normalized();
  RigidMotion world_from_view = RigidMotion::Identity();
  world_from_view.linear() << right, forward.cross(right), forward;
  world_from_view.translation() = eye;
  return world_from_view;
}

void add_range_noise(RangeView& view, double sigma, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> noise(0.0, sigma);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v))
        view.range(u, v) += noise(generator) / view.camera.ray(u, v).direction.norm();
}

void add_normal_noise(RangeView& view, double sigma_rad, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> noise(0.0, sigma_rad);
  for (auto& stored : view.normals) {
    if (!stored.allFinite()) continue;
    const Eigen::Vector3d normal = stored.cast<double>();
    const Eigen::Vector3d across = normal.unitOrthogonal();
    const double a = noise(generator), b = noise(generator);
    stored = (normal + std::tan(a) * across + std::tan(b) * normal.cross(across))
                 .normalized()
                 .cast<float>();
  }
}

}  // namespace relief::testing
