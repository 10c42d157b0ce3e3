#include "fusion/view_sampler.h"

#include <algorithm>
#include <array>
#include <utility>

namespace relief {

Result<ViewSampler> ViewSampler::create(const RangeView& view, const QuadSurfaceOptions& options) {
  ViewSampler sampler;
  sampler.world_from_view_ = view.world_from_view;
  sampler.view_from_world_ = view.world_from_view.inverse();
  sampler.surface_ = surface_of(view, options);
  if (sampler.empty()) return sampler;
  auto projection = ViewProjection::create(view);
  if (!projection) return projection.error();
  sampler.projection_ = std::move(projection).value();
  return sampler;
}

std::vector<Eigen::Vector3d> ViewSampler::surface_points() const {
  std::vector<Eigen::Vector3d> points;
  for (const SurfacePixel& pixel : surface_.pixels)
    if (pixel.corner)
      points.push_back(world_from_view_ * (surface_.centre + pixel.point.cast<double>()));
  return points;
}

std::optional<Observation> ViewSampler::observe(const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d point = view_from_world_ * point_in_world;
  const auto projected = projection_.pixel_of(point);
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
    const double footprint = projection_.pixel_footprint(point, projected->x(), projected->y());
    seen.clearance = std::min(seen.distance, (border - 1.0) * footprint);
  }
  return seen;
}

}  // namespace relief
