#include "scan/io/grids/cameras/grid_camera.h"

#include <algorithm>

#include "relief/scan/range_view.h"
#include "scan/io/grids/cameras/grid_samples.h"
#include "scan/views/projection_fits.h"

namespace relief {

namespace {

// Of the sample spacing. Single precision, 2^-24, allows so much up to 16,000 spacings off; beyond,
// a camera without a formula keeps the points where they are.
constexpr double kOnRay = 1e-3;

// The better of the model's own projection and the fitted one.
RationalProjectionFit best_projection(const GridSamples& samples, const Camera& model) {
  RationalProjectionFit best{projection_of(model), 0.0};
  best.rms_pixels = rms_pixels(samples, best.projection);
  const auto fit = fit_rational_projection(samples.points, samples.pixels);
  return fit && fit->rms_pixels < best.rms_pixels ? *fit : best;
}

// The ray of a pixel without a sample. Parallel rays whose lattice is not regular go through the
// place where the projection sees the pixel at the samples' mean depth.
Ray empty_ray(int u, int v, const Camera& model, const RationalProjectionFit& projection,
              const Eigen::Vector3d& mean) {
  Ray ray = model.ray(u, v);
  if (model.model() != Camera::Model::kOrthographic ||
      projection.rms_pixels > kGoodProjectionPixels)
    return ray;
  const Ray line = projection.projection.ray(u, v, ray.direction);
  const double slope = line.direction.dot(ray.direction);
  const Eigen::Vector3d at_mean =
      line.at((mean - line.origin).dot(ray.direction) / (slope != 0.0 ? slope : 1.0));
  if (!at_mean.allFinite()) return ray;
  return {at_mean - ray.range_of(at_mean) * ray.direction, ray.direction};
}

Grid<Ray> shifted_rays(const Grid<Eigen::Vector3d>& points, const Grid<double>& range,
                       const Camera& model, const RationalProjectionFit& projection,
                       const Eigen::Vector3d& mean) {
  Grid<Ray> rays(points.width(), points.height());
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (range(u, v) != range(u, v)) {
        rays(u, v) = empty_ray(u, v, model, projection, mean);
        continue;
      }
      const Eigen::Vector3d direction = model.ray(u, v).direction;
      rays(u, v) = {points(u, v) - range(u, v) * direction, direction};
    }
  }
  return rays;
}

void add_spherical_camera(const Grid<Eigen::Vector3d>& points, const Camera& model,
                          GridCamera& result) {
  const SphericalProjection& angles = *model.spherical_projection();
  result.rms_pixels = angles.rms_pixels(points);
  if (result.exact_model) {
    result.camera = model;
    return;
  }
  Grid<Ray> rays = shifted_rays(points, result.range, model, {}, Eigen::Vector3d::Zero());
  result.camera = result.rms_pixels <= kGoodProjectionPixels
                      ? Camera::ray_table(std::move(rays), angles)
                      : Camera::ray_table(std::move(rays), std::nullopt);
}

}  // namespace

GridCamera camera_through_points(const Grid<Eigen::Vector3d>& points, const Camera& model) {
  GridCamera result;
  result.range = Grid<double>(points.width(), points.height(), kNoSample);
  double largest = 0.0;
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (!points(u, v).allFinite()) continue;
      const Ray ray = model.ray(u, v);
      result.range(u, v) = ray.range_of(points(u, v));
      largest = std::max(largest, (ray.at(result.range(u, v)) - points(u, v)).norm());
    }
  }
  result.exact_model = model.model() != Camera::Model::kRayTable &&
                       largest <= kOnRay * median_distance_beside(points, 1, 0);
  if (model.spherical_projection()) {
    add_spherical_camera(points, model, result);
    return result;
  }
  const GridSamples samples = collect_samples(points);
  if (result.exact_model) {
    result.camera = model;
    result.rms_pixels = rms_pixels(samples, projection_of(model));
    return result;
  }
  const RationalProjectionFit projection = best_projection(samples, model);
  result.rms_pixels = projection.rms_pixels;
  result.camera = Camera::ray_table(
      shifted_rays(points, result.range, model, projection, samples.mean),
      projection.rms_pixels <= kGoodProjectionPixels ? std::optional(projection.projection)
                                                     : std::nullopt);
  return result;
}

}  // namespace relief
