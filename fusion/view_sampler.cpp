#include "fusion/view_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

#include "scan/discontinuities.h"
#include "scan/grid_normals.h"

namespace relief {

namespace {

// The measured normal where there is one, else that of the measured surface.
Grid<Eigen::Vector3f> surface_normals(const RangeView& view, const GridEdges& edges, int threads) {
  GridNormalOptions options;
  options.threads = threads;
  Grid<Eigen::Vector3f> normals = estimate_normals(view, edges, options);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_normal(u, v)) normals(u, v) = view.normals(u, v);
  return normals;
}

bool connected_quad(const GridEdges& edges, int u, int v) {
  return edges.connected(u, v, 1, 0) && edges.connected(u, v, 0, 1) &&
         edges.connected(u + 1, v, 0, 1) && edges.connected(u, v + 1, 1, 0);
}

double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// For white noise the distance between a sample and the mean of its four neighbours has variance
// (1 + 1/4) sigma^2. Curvature adds to it, so this errs on the large side.
double position_noise(const RangeView& view, const GridEdges& edges,
                      const Grid<Eigen::Vector3f>& normals) {
  std::vector<double> deviations;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!(edges.connected(u, v, 1, 0) && edges.connected(u, v, -1, 0) &&
            edges.connected(u, v, 0, 1) && edges.connected(u, v, 0, -1)))
        continue;
      const Eigen::Vector3d mean = 0.25 * (view.point(u + 1, v) + view.point(u - 1, v) +
                                           view.point(u, v + 1) + view.point(u, v - 1));
      const double deviation = std::abs(normals(u, v).cast<double>().dot(view.point(u, v) - mean));
      if (std::isfinite(deviation)) deviations.push_back(deviation);
    }
  }
  return 1.4826 * median(deviations) / std::sqrt(1.25);
}

Eigen::Vector3d mean_point(const RangeView& view) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      sum += view.point(u, v);
      ++count;
    }
  }
  return sum / static_cast<double>(std::max<std::size_t>(count, 1));
}

// For a camera that is only a table of rays: a rational map fitted to the samples.
std::optional<RationalProjection> fitted_guess(const RangeView& view) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      points.push_back(view.point(u, v));
      pixels.emplace_back(u, v);
    }
  }
  const auto fit = fit_rational_projection(points, pixels);
  return fit ? std::optional(fit->projection) : std::nullopt;
}

}  // namespace

Result<ViewSampler> ViewSampler::create(const RangeView& view, const SamplerOptions& options) {
  ViewSampler sampler;
  sampler.camera_ = view.camera;
  sampler.world_from_view_ = view.world_from_view;
  sampler.view_from_world_ = view.world_from_view.inverse();
  const GridEdges edges = connect_samples(view);
  const Grid<Eigen::Vector3f> normals = surface_normals(view, edges, options.threads);
  const Grid<std::uint8_t> border = boundary_distance(view, edges);
  sampler.spacing_ = sample_spacing(view);
  sampler.noise_ = position_noise(view, edges, normals);

  const auto quad_at = [&](int u, int v) {
    if (!connected_quad(edges, u, v)) return false;
    for (int k = 0; k < 4; ++k) {
      const int cu = u + (k & 1), cv = v + (k >> 1);
      if (!normals(cu, cv).allFinite() || !(view.confidence_at(cu, cv) > 0.0f)) return false;
    }
    return true;
  };
  int u0 = view.width(), v0 = view.height(), u1 = -1, v1 = -1;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!quad_at(u, v)) continue;
      u0 = std::min(u0, u), u1 = std::max(u1, u + 1);
      v0 = std::min(v0, v), v1 = std::max(v1, v + 1);
    }
  }
  if (u1 < u0) return sampler;
  if (!view.camera.can_project()) {
    sampler.guess_ = fitted_guess(view);
    if (!sampler.guess_)
      return Error{ErrorKind::kUnsolvable, "view `" + view.name +
                                               "`: its table of rays has no projection and too few "
                                               "samples to fit one; give the view a camera model"};
  }

  sampler.first_u_ = u0;
  sampler.first_v_ = v0;
  sampler.pixels_ = Grid<Pixel>(u1 - u0 + 1, v1 - v0 + 1);
  sampler.centre_ = mean_point(view);
  for (int v = v0; v <= v1; ++v) {
    for (int u = u0; u <= u1; ++u) {
      if (!view.has_sample(u, v)) continue;
      Pixel& pixel = sampler.pixels_(u - u0, v - v0);
      pixel.point = (view.point(u, v) - sampler.centre_).cast<float>();
      pixel.normal = normals(u, v);
      pixel.border = border(u, v);
      const double cosine =
          -normals(u, v).cast<double>().dot(view.camera.ray(u, v).direction.normalized());
      const double ramp = std::min(1.0, (border(u, v) + 0.1) / (options.silhouette_ramp + 0.1));
      pixel.weight = static_cast<float>(view.confidence_at(u, v) * std::max(0.05, cosine) * ramp);
      pixel.quad = quad_at(u, v);
    }
  }
  for (int v = 0; v + 1 < sampler.pixels_.height(); ++v) {
    for (int u = 0; u + 1 < sampler.pixels_.width(); ++u) {
      if (!sampler.pixels_(u, v).quad) continue;
      for (int k = 0; k < 4; ++k) sampler.pixels_(u + (k & 1), v + (k >> 1)).corner = true;
    }
  }
  for (const Pixel& pixel : sampler.pixels_) sampler.surface_points_ += pixel.corner;
  return sampler;
}

std::vector<Eigen::Vector3d> ViewSampler::surface_points() const {
  std::vector<Eigen::Vector3d> points;
  points.reserve(surface_points_);
  for (const Pixel& pixel : pixels_)
    if (pixel.corner) points.push_back(world_from_view_ * (centre_ + pixel.point.cast<double>()));
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
  const double x = projected->x() - first_u_, y = projected->y() - first_v_;
  if (!(x >= 0.0 && y >= 0.0 && x < pixels_.width() - 1 && y < pixels_.height() - 1))
    return std::nullopt;
  const int u = static_cast<int>(x), v = static_cast<int>(y);
  if (!pixels_(u, v).quad) return std::nullopt;

  const double a = x - u, b = y - v;
  const std::array<double, 4> share{(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
  const Eigen::Vector3d local = point - centre_;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(), place = Eigen::Vector3d::Zero();
  double to_tangent_planes = 0.0, border = 0.0;
  Observation seen;
  for (int k = 0; k < 4; ++k) {
    const Pixel& corner = pixels_(u + (k & 1), v + (k >> 1));
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
  seen.range_gap = (local - place).norm();
  seen.normal = world_from_view_.linear() * normal / length;
  if (seen.distance > 0.0 && border > 1.0) {
    const double u_full = projected->x(), v_full = projected->y();
    seen.clearance =
        std::min(seen.distance, (border - 1.0) * pixel_footprint(point, u_full, v_full));
  }
  return seen;
}

}  // namespace relief
