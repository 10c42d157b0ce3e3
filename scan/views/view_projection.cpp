#include "scan/views/view_projection.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "scan/views/projection_fits.h"

namespace relief {

namespace {

// For a camera that is only a table of rays: a rational map fitted to points on its rays, at the
// samples and well behind them, since samples of a flat surface alone do not determine the map.
std::optional<RationalProjection> fitted_guess(const RangeView& view) {
  const double depth = sample_spacing(view) * std::hypot(view.width(), view.height());
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const Ray ray = view.camera.ray(u, v);
      for (const double behind : {0.0, depth}) {
        points.push_back(ray.at(view.range(u, v)) + behind * ray.direction.normalized());
        pixels.emplace_back(u, v);
      }
    }
  }
  const auto fit = fit_rational_projection(points, pixels);
  return fit ? std::optional(fit->projection) : std::nullopt;
}

}  // namespace

Result<ViewProjection> ViewProjection::create(const RangeView& view) {
  ViewProjection projection;
  projection.camera_ = view.camera;
  if (!view.camera.can_project()) {
    projection.guess_ = fitted_guess(view);
    if (!projection.guess_)
      return Error{ErrorKind::kUnsolvable, "view `" + view.name +
                                               "`: its table of rays has no projection and too few "
                                               "samples to fit one; give the view a camera model"};
  }
  return projection;
}

// A few Gauss-Newton steps on (u, v, t) towards the ray through the point.
std::optional<Eigen::Vector2d> ViewProjection::pixel_of(const Eigen::Vector3d& point) const {
  if (!guess_) return camera_.project(point);
  auto pixel = guess_->project(point);
  if (!pixel) return std::nullopt;
  for (int iteration = 0; iteration < 4; ++iteration) {
    const double u = std::clamp((*pixel).x(), 0.0, camera_.width() - 1.0);
    const double v = std::clamp((*pixel).y(), 0.0, camera_.height() - 1.0);
    const double du = u + 0.5 < camera_.width() - 1.0 ? 0.5 : -0.5;
    const double dv = v + 0.5 < camera_.height() - 1.0 ? 0.5 : -0.5;
    const Ray ray = camera_.ray_at(u, v);
    const double t = ray.range_of(point);
    Eigen::Matrix3d jacobian;
    jacobian.col(0) = (camera_.ray_at(u + du, v).at(t) - ray.at(t)) / du;
    jacobian.col(1) = (camera_.ray_at(u, v + dv).at(t) - ray.at(t)) / dv;
    jacobian.col(2) = ray.direction;
    const Eigen::Vector3d step = jacobian.partialPivLu().solve(point - ray.at(t));
    if (!step.allFinite()) return std::nullopt;
    pixel = Eigen::Vector2d(u + step.x(), v + step.y());
  }
  return pixel;
}

double ViewProjection::pixel_footprint(const Eigen::Vector3d& point, double u, double v) const {
  const Camera::Model model = camera_.model();
  if (model == Camera::Model::kPinhole || model == Camera::Model::kPinholeGl) {
    const PinholeIntrinsics& k = camera_.intrinsics();
    return std::abs(point.z()) / std::max(std::abs(k.fx), std::abs(k.fy));
  }
  const Ray ray = camera_.ray_at(u, v);
  const double t = ray.range_of(point);
  const double right = (camera_.ray_at(u + 1.0, v).at(t) - ray.at(t)).norm();
  const double down = (camera_.ray_at(u, v + 1.0).at(t) - ray.at(t)).norm();
  return std::min(right, down);
}

}  // namespace relief
