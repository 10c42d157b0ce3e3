#include "tests/registration/bumpy_object.h"

#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>

#include "relief/scan/rigid_motion.h"

namespace relief::testing {

namespace {

// Negative inside; `p` in radii of the object. Its gradient is bounded by about 2.5.
double implicit_value(const Eigen::Vector3d& p) {
  const double body = p.cwiseQuotient(Eigen::Vector3d(1.0, 0.85, 1.15)).norm() - 1.0;
  const double bumps = std::sin(7.0 * p.x() + 1.0) * std::cos(6.0 * p.y()) +
                       std::sin(8.0 * p.z() - 3.0 * p.x()) + std::cos(9.0 * p.y() + 4.0 * p.z());
  return body + 0.03 * bumps;
}

Eigen::Vector3d gradient(const Eigen::Vector3d& p) {
  const Eigen::Vector3d axes(1.0, 0.85, 1.15);
  const Eigen::Vector3d scaled = p.cwiseQuotient(axes);
  const Eigen::Vector3d body = scaled.cwiseQuotient(axes) / scaled.norm();
  const double u = 7.0 * p.x() + 1.0, v = 6.0 * p.y();
  const double along_xz = std::cos(8.0 * p.z() - 3.0 * p.x());
  const double along_yz = -std::sin(9.0 * p.y() + 4.0 * p.z());
  const Eigen::Vector3d bumps(7.0 * std::cos(u) * std::cos(v) - 3.0 * along_xz,
                              -6.0 * std::sin(u) * std::sin(v) + 9.0 * along_yz,
                              8.0 * along_xz + 4.0 * along_yz);
  return body + 0.03 * bumps;
}

Eigen::Vector3d random_direction(std::mt19937& generator) {
  std::normal_distribution<double> normal;
  const double x = normal(generator), y = normal(generator), z = normal(generator);
  return Eigen::Vector3d(x, y, z).normalized();
}

}  // namespace

Surface bumpy_object(double radius, const Eigen::Vector3d& centre) {
  return [=](const Ray& ray) -> std::optional<SurfaceHit> {
    const Ray local{(ray.origin - centre) / radius, ray.direction.normalized()};
    const double middle = -local.origin.dot(local.direction);
    const double offset = local.at(middle).squaredNorm();
    constexpr double kBound = 1.4;
    if (offset > kBound * kBound) return std::nullopt;
    const double half = std::sqrt(kBound * kBound - offset);
    double t = middle - half, value = implicit_value(local.at(t));
    while (t < middle + half && value > 1e-3) {
      t += std::max(2e-3, 0.3 * value);
      value = implicit_value(local.at(t));
    }
    if (t >= middle + half) return std::nullopt;
    for (int i = 0; i < 6 && std::abs(value) > 1e-15; ++i) {  // Newton along the ray.
      const double slope = gradient(local.at(t)).dot(local.direction);
      if (std::abs(slope) < 1e-3) return std::nullopt;
      t -= value / slope;
      value = implicit_value(local.at(t));
    }
    return SurfaceHit{t * radius / ray.direction.norm(), gradient(local.at(t)).normalized()};
  };
}

std::vector<RangeView> ring_of_views(const RingOptions& options) {
  const double distance = 6.0 * options.radius;
  const double focal = 0.45 * options.pixels * distance / (1.3 * options.radius);
  const double middle = 0.5 * (options.pixels - 1);
  const Camera camera =
      Camera::pinhole(options.pixels, options.pixels, {focal, focal, middle, middle});
  std::vector<RangeView> views;
  for (int i = 0; i < options.views; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / options.views;
    const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), options.tilts[i % 2]);
    const Eigen::Vector3d eye = options.centre + distance * direction.normalized();
    views.push_back(
        render(bumpy_object(options.radius, options.centre), camera, look_at(eye, options.centre)));
    views.back().name = "view" + std::to_string(i);
    add_range_noise(views.back(), options.noise * distance / focal,
                    options.seed + static_cast<std::uint32_t>(i));
  }
  return views;
}

std::vector<RangeView> perturbed(std::vector<RangeView> views, const Eigen::Vector3d& centre,
                                 double angle, double shift, std::uint32_t seed) {
  std::mt19937 generator(seed);
  for (std::size_t i = 1; i < views.size(); ++i) {
    const Eigen::AngleAxisd turn(angle, random_direction(generator));
    const Eigen::Vector3d move = shift * random_direction(generator);
    views[i].world_from_view = Eigen::Translation3d(centre + move) * turn *
                               Eigen::Translation3d(-centre) * views[i].world_from_view;
  }
  return views;
}

std::vector<RangeView> without_poses(std::vector<RangeView> views) {
  for (RangeView& view : views) {
    view.pose = PoseKind::kAbsent;
    view.world_from_view = RigidMotion::Identity();
  }
  return views;
}

std::vector<double> mean_displacements(const std::vector<RangeView>& views,
                                       const std::vector<RigidMotion>& estimate,
                                       const std::vector<RigidMotion>& truth) {
  std::vector<Eigen::Vector3d> at_estimate, at_truth;
  std::vector<std::size_t> owner;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (int v = 0; v < views[i].height(); v += 2) {
      for (int u = 0; u < views[i].width(); u += 2) {
        if (!views[i].has_sample(u, v)) continue;
        at_estimate.push_back(estimate[i] * views[i].point(u, v));
        at_truth.push_back(truth[i] * views[i].point(u, v));
        owner.push_back(i);
      }
    }
  }
  const auto count = static_cast<Eigen::Index>(owner.size());
  const Eigen::Map<const Eigen::Matrix3Xd> a(at_estimate.front().data(), 3, count);
  const Eigen::Map<const Eigen::Matrix3Xd> b(at_truth.front().data(), 3, count);
  const RigidMotion truth_from_estimate = best_rigid_motion(a, b);
  std::vector<double> sums(views.size(), 0.0), counts(views.size(), 0.0);
  for (std::size_t k = 0; k < owner.size(); ++k) {
    sums[owner[k]] += (truth_from_estimate * at_estimate[k] - at_truth[k]).norm();
    counts[owner[k]] += 1.0;
  }
  for (std::size_t i = 0; i < views.size(); ++i) sums[i] /= std::max(1.0, counts[i]);
  return sums;
}

std::vector<RigidMotion> poses_of(const std::vector<RangeView>& views) {
  std::vector<RigidMotion> poses;
  for (const auto& view : views) poses.push_back(view.world_from_view);
  return poses;
}

}  // namespace relief::testing
