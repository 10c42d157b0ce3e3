#include "relief/scan/camera.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include <Eigen/Dense>

namespace relief {

namespace {

Ray pinhole_ray(const PinholeIntrinsics& k, double u, double v, double forward) {
  return {Eigen::Vector3d::Zero(), {(u - k.cx) / k.fx, (v - k.cy) / k.fy, forward}};
}

Ray interpolate(const Grid<Ray>& rays, double u, double v) {
  u = std::clamp(u, 0.0, rays.width() - 1.0);
  v = std::clamp(v, 0.0, rays.height() - 1.0);
  const int u0 = std::min(static_cast<int>(u), std::max(0, rays.width() - 2));
  const int v0 = std::min(static_cast<int>(v), std::max(0, rays.height() - 2));
  const int u1 = std::min(u0 + 1, rays.width() - 1), v1 = std::min(v0 + 1, rays.height() - 1);
  const double a = u - u0, b = v - v0;
  const auto blend = [&](auto member) -> Eigen::Vector3d {
    return (1 - b) * ((1 - a) * rays(u0, v0).*member + a * rays(u1, v0).*member) +
           b * ((1 - a) * rays(u0, v1).*member + a * rays(u1, v1).*member);
  };
  return {blend(&Ray::origin), blend(&Ray::direction)};
}

// The means of `factor` angles one after the other.
std::vector<double> mean_angles(const std::vector<double>& angles, int count, int factor) {
  std::vector<double> means(static_cast<std::size_t>(count), 0.0);
  for (std::size_t i = 0; i < means.size() * static_cast<std::size_t>(factor); ++i)
    means[i / static_cast<std::size_t>(factor)] += angles[i] / factor;
  return means;
}

}  // namespace

Camera Camera::pinhole(int width, int height, const PinholeIntrinsics& intrinsics) {
  assert(intrinsics.fx != 0.0 && intrinsics.fy != 0.0);
  Camera camera;
  camera.model_ = Model::kPinhole;
  camera.width_ = width;
  camera.height_ = height;
  camera.intrinsics_ = intrinsics;
  return camera;
}

Camera Camera::pinhole_gl(int width, int height, const PinholeIntrinsics& intrinsics) {
  Camera camera = pinhole(width, height, intrinsics);
  camera.model_ = Model::kPinholeGl;
  return camera;
}

Camera Camera::orthographic(int width, int height, const Eigen::Vector3d& origin,
                            const Eigen::Vector3d& step_u, const Eigen::Vector3d& step_v,
                            const Eigen::Vector3d& direction) {
  Camera camera;
  camera.model_ = Model::kOrthographic;
  camera.width_ = width;
  camera.height_ = height;
  camera.origin_ = origin;
  camera.step_u_ = step_u;
  camera.step_v_ = step_v;
  camera.direction_ = direction;
  return camera;
}

Camera Camera::spherical(SphericalProjection angles) {
  assert(angles.valid());
  Camera camera;
  camera.model_ = Model::kSpherical;
  camera.width_ = static_cast<int>(angles.azimuth.size());
  camera.height_ = static_cast<int>(angles.elevation.size());
  camera.spherical_ = std::make_shared<const SphericalProjection>(std::move(angles));
  return camera;
}

Camera Camera::ray_table(Grid<Ray> rays, std::optional<RationalProjection> projection) {
  Camera camera;
  camera.model_ = Model::kRayTable;
  camera.width_ = rays.width();
  camera.height_ = rays.height();
  camera.table_ = std::make_shared<const Grid<Ray>>(std::move(rays));
  camera.projection_ = std::move(projection);
  return camera;
}

Camera Camera::ray_table(Grid<Ray> rays, SphericalProjection projection) {
  Camera camera = ray_table(std::move(rays), std::nullopt);
  camera.spherical_ = std::make_shared<const SphericalProjection>(std::move(projection));
  return camera;
}

Ray Camera::ray(int u, int v) const {
  if (model_ == Model::kPinhole) return pinhole_ray(intrinsics_, u, v, 1.0);  // The most frequent.
  if (model_ == Model::kRayTable) return (*table_)(u, v);
  return ray_at(u, v);
}

Ray Camera::ray_at(double u, double v) const {
  switch (model_) {
    case Model::kPinhole:
      return pinhole_ray(intrinsics_, u, v, 1.0);
    case Model::kPinholeGl:
      return pinhole_ray(intrinsics_, u, v, -1.0);
    case Model::kOrthographic:
      return {origin_ + u * step_u_ + v * step_v_, direction_};
    case Model::kSpherical:
      return spherical_->ray(u, v);
    case Model::kRayTable:
      return interpolate(*table_, u, v);
  }
  return {};
}

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& point) const {
  switch (model_) {
    case Model::kPinhole:
    case Model::kPinholeGl: {
      const double t = model_ == Model::kPinhole ? point.z() : -point.z();
      if (!(t > 0.0)) return std::nullopt;
      return Eigen::Vector2d(intrinsics_.fx * point.x() / t + intrinsics_.cx,
                             intrinsics_.fy * point.y() / t + intrinsics_.cy);
    }
    case Model::kOrthographic: {
      // point - origin = u step_u + v step_v + t direction.
      Eigen::Matrix3d axes;
      axes << step_u_, step_v_, direction_;
      return Eigen::Vector2d((axes.inverse() * (point - origin_)).head<2>());
    }
    case Model::kSpherical:
      return spherical_->project(point);
    case Model::kRayTable:
      if (spherical_) return spherical_->project(point);
      return projection_ ? projection_->project(point) : std::nullopt;
  }
  return std::nullopt;
}

std::optional<Camera> Camera::binned(int factor) const {
  if (factor < 2 || model_ == Model::kRayTable) return std::nullopt;
  Camera camera = *this;
  camera.width_ = width_ / factor;
  camera.height_ = height_ / factor;
  if (camera.width_ < 2 || camera.height_ < 2) return std::nullopt;
  const double middle = (factor - 1) / 2.0;  // Of the first large pixel.
  camera.intrinsics_ = {intrinsics_.fx / factor, intrinsics_.fy / factor,
                        (intrinsics_.cx - middle) / factor, (intrinsics_.cy - middle) / factor};
  camera.origin_ = origin_ + middle * (step_u_ + step_v_);
  camera.step_u_ = factor * step_u_;
  camera.step_v_ = factor * step_v_;
  if (spherical_)
    camera.spherical_ = std::make_shared<const SphericalProjection>(
        SphericalProjection{mean_angles(spherical_->azimuth, camera.width_, factor),
                            mean_angles(spherical_->elevation, camera.height_, factor)});
  return camera;
}

std::string_view to_string(Camera::Model model) {
  switch (model) {
    case Camera::Model::kPinhole:
      return "pinhole";
    case Camera::Model::kPinholeGl:
      return "pinhole_gl";
    case Camera::Model::kOrthographic:
      return "orthographic";
    case Camera::Model::kSpherical:
      return "spherical";
    case Camera::Model::kRayTable:
      return "ray table";
  }
  return "unknown";
}

}  // namespace relief
