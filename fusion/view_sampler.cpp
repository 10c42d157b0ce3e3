#include "fusion/view_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

namespace relief {

namespace {

// For a camera that is only a table of rays: a rational map fitted to points on its rays, at the
// samples and well behind them, since samples of a flat surface alone do not determine the map.
std::optional<RationalProjection> fitted_guess(const RangeView& view, double spacing) {
  const double depth = spacing * std::hypot(view.width(), view.height());
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

Result<ViewSampler> ViewSampler::create(const RangeView& view, const QuadSurfaceOptions& options) {
  ViewSampler sampler;
  sampler.camera_ = view.camera;
  sampler.world_from_view_ = view.world_from_view;
  sampler.view_from_world_ = view.world_from_view.inverse();
  sampler.surface_ = surface_of(view, options);
  if (!sampler.empty() && !view.camera.can_project()) {
    sampler.guess_ = fitted_guess(view, sampler.spacing());
    if (!sampler.guess_)
      return Error{ErrorKind::kUnsolvable, "view `" + view.name +
                                               "`: its table of rays has no projection and too few "
                                               "samples to fit one; give the view a camera model"};
  }
  return sampler;
}

std::vector<Eigen::Vector3d> ViewSampler::surface_points() const {
  std::vector<Eigen::Vector3d> points;
  for (const SurfacePixel& pixel : surface_.pixels)
    if (pixel.corner)
      points.push_back(world_from_view_ * (surface_.centre + pixel.point.cast<double>()));
  return points;
}

// A few Gauss-Newton steps on (u, v, t) towards the ray through the point.
std::optional<Eigen::Vector2d> ViewSampler::project(const Eigen::Vector3d& point) const {
  if (camera_.can_project()) return camera_.project(point);
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

double ViewSampler::pixel_footprint(const Eigen::Vector3d& point, double u, double v) const {
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

std::optional<Observation> ViewSampler::observe(const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d point = view_from_world_ * point_in_world;
  const auto projected = project(point);
  if (!projected) return std::nullopt;
  const double x = projected->x() - surface_.first_u, y = projected->y() - surface_.first_v;
  if (!(x >= 0.0 && y >= 0.0 && x < surface_.pixels.width() - 1 &&
        y < surface_.pixels.height() - 1))
    return std::nullopt;
  const int u = static_cast<int>(x), v = static_cast<int>(y);
  if (!surface_.pixels(u, v).quad) return std::nullopt;

  const double a = x - u, b = y - v;
  const std::array<double, 4> share{(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
  const Eigen::Vector3d local = point - surface_.centre;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(), place = Eigen::Vector3d::Zero();
  double to_tangent_planes = 0.0, border = 0.0;
  Observation seen;
  for (int k = 0; k < 4; ++k) {
    const SurfacePixel& corner = surface_.pixels(u + (k & 1), v + (k >> 1));
    const double s = share[static_cast<std::size_t>(k)];
    const Eigen::Vector3d n = corner.normal.cast<double>(), p = corner.point.cast<double>();
    normal += s * n;
    place += s * p;
    to_tangent_planes += s * n.dot(local - p);
    seen.weight += s * corner.weight;
    border += s * corner.border;
  }
  const double length = normal.norm();
  if (!(length > 0.1)) return std::nullopt;
  // On a curved surface the chord between samples errs to one side and their tangent planes err by
  // the same amount to the other.
  seen.distance = 0.5 * (normal.dot(local - place) + to_tangent_planes) / length;
  seen.matter_depth = border * surface_.spacing;
  seen.range_gap = (local - place).norm();
  seen.normal = world_from_view_.linear() * normal / length;
  if (seen.distance > 0.0 && border > 1.0) {
    const double footprint = pixel_footprint(point, projected->x(), projected->y());
    seen.clearance = std::min(seen.distance, (border - 1.0) * footprint);
  }
  return seen;
}

}  // namespace relief
