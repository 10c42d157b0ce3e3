#include "fusion/views/view_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace relief::fusion {

namespace {

// Length of the mean of the directions of views: 1 where all look the same way, and 0.5 where they
// are spread over a half space, from where the sides of an object are seen down to its base.
constexpr double kOneSide = 0.7;

// Views that meet the surface at more than 60 degrees are asked a second time, at the foot: there
// the surface curves away between where the ray meets it and the foot. Flatter ones are not: it
// would cost time and, next to relief of few samples, a little accuracy.
constexpr double kSteep = 0.5;  // Cosine.

// The foot belongs to the same surface when the normals there differ by less than about 25 degrees.
constexpr double kSameSurface = 0.9;  // Cosine.

// Space is surely empty so many standard deviations in front of a surface: at 0 the noise of dark
// patches digs dents.
constexpr double kSurely = 2.0;

// Pixels by which the projection of a box may stand out of that of its corners.
constexpr int kBoxMargin = 1;

Eigen::Vector3d mean_direction(const RangeView& view, const PagedSurface& surface) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int v = 0; v < surface.pixels.height(); ++v)
    for (int u = 0; u < surface.pixels.width(); ++u)
      if (surface.corner(u, v))
        sum += view.camera.ray(u + surface.first_u, v + surface.first_v).direction.normalized();
  return sum.normalized();
}

Grid<float> depths_along(const Eigen::Vector3d& axis, const PagedSurface& surface) {
  Grid<float> depths(surface.pixels.width(), surface.pixels.height(),
                     -std::numeric_limits<float>::infinity());
  for (int v = 0; v < depths.height(); ++v)
    for (int u = 0; u < depths.width(); ++u)
      if (surface.corner(u, v)) depths(u, v) = static_cast<float>(surface.offset(u, v).dot(axis));
  return depths;
}

double farthest_range(const PagedSurface& surface) {
  double squared = 0.0;
  for (int v = 0; v < surface.marks.height(); ++v)
    for (int u = 0; u < surface.marks.width(); ++u)
      if (surface.measured_corner(u, v))
        squared = std::max(squared, (surface.centre + surface.offset(u, v)).squaredNorm());
  return std::sqrt(squared);
}

// Corner k of a quad, row by row.
template <typename T>
const T& corner(const PagedGrid<T>& grid, const ViewSampler::Quad& quad, int k) {
  return grid(quad.corners.u + (k & 1), quad.corners.v + (k >> 1));
}

std::array<double, 8> numbers_of(const SurfacePixel& pixel) {
  static_assert(sizeof(SurfacePixel) == 8 * sizeof(float));
  std::array<float, 8> numbers;
  std::memcpy(numbers.data(), &pixel, sizeof(pixel));
  std::array<double, 8> values;
  std::copy(numbers.begin(), numbers.end(), values.begin());
  return values;
}

std::array<Eigen::Vector3d, 8> corners_of(const Eigen::AlignedBox3d& box) {
  std::array<Eigen::Vector3d, 8> corners;
  for (int k = 0; k < 8; ++k)
    corners[static_cast<std::size_t>(k)] =
        box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
  return corners;
}

}  // namespace

// The surface where the ray of a point meets it.
struct ViewSampler::Patch {
  SurfacePatch surface;  // View frame.
  double border = 0.0;   // Distance to the silhouette [pixels].
};

Result<ViewSampler> ViewSampler::create(const RangeView& view, const PagedSurfaceOptions& options) {
  Result<ViewSampler> created = ViewSampler();
  ViewSampler& sampler = *created;
  sampler.name_ = view.name;
  sampler.world_from_view_ = view.world_from_view;
  sampler.view_from_world_ = view.world_from_view.inverse();
  sampler.surface_ = surface_of(view, options);
  sampler.has_centre_ = view.camera.model() != Camera::Model::kOrthographic &&
                        view.camera.model() != Camera::Model::kRayTable;
  sampler.silhouette_ramp_ = options.weights.silhouette_ramp;
  if (sampler.empty()) return created;
  auto projection = ViewProjection::create(view);
  if (!projection) return projection.error();
  sampler.projection_ = std::move(projection).value();
  if (sampler.has_centre_) sampler.farthest_range_ = farthest_range(sampler.surface_);
  sampler.depth_axis_ = mean_direction(view, sampler.surface_);
  sampler.depths_ =
      DepthPyramid(depths_along(sampler.depth_axis_, sampler.surface_), options.memory);
  return created;
}

std::optional<ViewSampler::Quad> ViewSampler::quad_at(const Eigen::Vector3d& point) const {
  const auto projected = projection_.pixel_of(point);
  if (!projected) return std::nullopt;
  const Eigen::Vector2d in_crop = *projected - Eigen::Vector2d(surface_.first_u, surface_.first_v);
  const auto corners = SurfaceQuad::at(in_crop, surface_.pixels.width(), surface_.pixels.height());
  if (!corners || !surface_.quad(corners->u, corners->v)) return std::nullopt;
  return Quad{point, *projected, *corners};
}

std::optional<ViewSampler::Quad> ViewSampler::quad_on_ray_of(
    const Eigen::Vector3d& point_in_world) const {
  return quad_at(view_from_world_ * point_in_world);
}

// A point and the surface on its ray are farther apart than their depths.
ViewSampler::Side ViewSampler::side(const Quad& quad, double reach) const {
  const double depth = depth_axis_.dot(quad.point - surface_.centre);
  double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
  for (int k = 0; k < 4; ++k) {
    const double at_corner = depths_.at(quad.corners.u + (k & 1), quad.corners.v + (k >> 1));
    nearest = std::min(nearest, at_corner);
    farthest = std::max(farthest, at_corner);
  }
  if (depth < nearest - reach) return Side::kInFront;
  return depth > farthest + reach ? Side::kBehind : Side::kNear;
}

std::optional<ViewSampler::Patch> ViewSampler::patch_on(const Quad& quad) const {
  // Point, weight, normal and border: see SurfacePixel.
  std::array<double, 8> sum{};
  double offset = 0.0;
  for (int k = 0; k < 4; ++k) {
    const auto values = numbers_of(corner(surface_.pixels, quad, k));
    const double share = quad.corners.shares[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < 8; ++i) sum[i] += share * values[i];
    offset += share * (values[0] * values[4] + values[1] * values[5] + values[2] * values[6]);
  }
  Patch patch{{surface_.centre, {sum[0], sum[1], sum[2]}, {sum[4], sum[5], sum[6]}, offset, sum[3]},
              sum[7]};
  if (!patch.surface.normalize()) return std::nullopt;
  return patch;
}

std::optional<Observation> ViewSampler::observe(const Eigen::Vector3d& point_in_world,
                                                double foot_reach) const {
  const auto quad = quad_on_ray_of(point_in_world);
  return quad ? observe(*quad, foot_reach) : std::nullopt;
}

std::optional<Observation> ViewSampler::observe(const Quad& quad, double foot_reach) const {
  const Eigen::Vector3d& point = quad.point;
  const auto patch = patch_on(quad);
  if (!patch) return std::nullopt;
  const auto& [surface, border] = *patch;
  Observation seen;
  seen.noisy = surface_.noisy_quad(quad.corners.u, quad.corners.v);
  seen.distance = surface.distance(point);
  if (has_centre_)
    seen.relative_stddev = errors_.relative_stddev((surface.origin + surface.chord).norm());
  const double information = surface.weight / silhouette_weight(border, silhouette_ramp_);
  const double variance = errors_.relative_variance(information, seen.relative_stddev);
  seen.weight = surface.weight / variance;
  seen.information = information / variance;
  seen.in_front =
      seen.distance - kSurely * errors_.stddev_at(seen.information, seen.relative_stddev);
  seen.border = border;
  seen.matter_depth = border * surface_.spacing;
  seen.range_gap = (point - surface.origin - surface.chord).norm();
  seen.normal = world_from_view_.linear() * surface.normal;
  if (seen.in_front > 0.0 && border > 1.0) {
    const double footprint = projection_.pixel_footprint(point, quad.pixel.x(), quad.pixel.y());
    seen.clearance = std::min(seen.in_front, (border - 1.0) * footprint);
  }
  if (std::abs(seen.distance) < foot_reach && std::abs(seen.distance) < kSteep * seen.range_gap) {
    const auto quad_at_foot = quad_at(point - seen.distance * surface.normal);
    const auto foot = quad_at_foot ? patch_on(*quad_at_foot) : std::nullopt;
    if (foot && foot->surface.normal.dot(surface.normal) > kSameSurface)
      seen.distance = foot->surface.distance(point);
  }
  return seen;
}

std::optional<Eigen::Vector3d> ViewSampler::colour(const Eigen::Vector3d& point_in_world) const {
  if (!has_colours()) return std::nullopt;
  const auto quad = quad_on_ray_of(point_in_world);
  if (!quad) return std::nullopt;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 0; k < 4; ++k) {
    const auto& [red, green, blue] = corner(surface_.colours, *quad, k);
    sum += quad->corners.shares[static_cast<std::size_t>(k)] * Eigen::Vector3d(red, green, blue);
  }
  return sum;
}

bool ViewSampler::concerns(const Eigen::AlignedBox3d& box_in_world, double reach) const {
  if (box_in_world.isEmpty()) return false;
  Eigen::AlignedBox2i pixels;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& corner : corners_of(box_in_world)) {
    const Eigen::Vector3d point = view_from_world_ * corner;
    const auto projected = projection_.pixel_of(point);
    if (!projected || !(projected->array().abs() < 1e8).all()) return true;
    const Eigen::Vector2i pixel = projected->array().floor().cast<int>();
    pixels.extend(pixel - Eigen::Vector2i(surface_.first_u, surface_.first_v));
    nearest = std::min(nearest, depth_axis_.dot(point - surface_.centre));
  }
  pixels.min().array() -= kBoxMargin;
  pixels.max().array() += 1 + kBoxMargin;
  // A point and the surface on its ray are farther apart than their depths.
  return nearest - depths_.greatest(pixels) < reach;
}

bool seen_from_one_side(const std::vector<ViewSampler>& views) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ViewSampler& view : views) sum += view.direction();
  return sum.norm() > kOneSide * static_cast<double>(views.size());
}

}  // namespace relief::fusion
