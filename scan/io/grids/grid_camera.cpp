#include "scan/io/grids/grid_camera.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <Eigen/Dense>

#include "relief/scan/range_view.h"
#include "scan/base/median.h"
#include "scan/io/grids/normal_side.h"

namespace relief {

namespace {

constexpr double kGoodProjectionPixels = 0.5;  // RMS: more names the pixel beside
// Of the sample spacing. Single precision, 2^-24, allows so much up to 16,000 spacings off; beyond,
// a camera without a formula keeps the points where they are.
constexpr double kOnRay = 1e-3;
// The residual of a spherical camera over that of the other models: 1.5, as between those (see
// fit_camera), for each of two coordinates, rounded down.
constexpr double kSphericalGain = 0.4;

struct Samples {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
};

Samples collect(const Grid<Eigen::Vector3d>& points) {
  Samples samples;
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (!points(u, v).allFinite()) continue;
      samples.points.push_back(points(u, v));
      samples.pixels.emplace_back(u, v);
      samples.mean += points(u, v);
    }
  }
  if (!samples.points.empty()) samples.mean /= static_cast<double>(samples.points.size());
  return samples;
}

double median_spacing(const Grid<Eigen::Vector3d>& points) {
  std::vector<double> lengths;
  for (int v = 0; v < points.height(); ++v)
    for (int u = 0; u + 1 < points.width(); ++u)
      if (const double length = (points(u + 1, v) - points(u, v)).norm(); length == length)
        lengths.push_back(length);
  return median(lengths);
}

// A camera with a formula, as a ratio of affine functions.
RationalProjection projection_of(const Camera& camera) {
  const auto& k = camera.intrinsics();
  switch (camera.model()) {
    case Camera::Model::kPinhole:
      return {{k.fx, 0, k.cx, 0}, {0, 0, 1, 0}, {0, k.fy, k.cy, 0}, {0, 0, 1, 0}};
    case Camera::Model::kPinholeGl:
      return {{k.fx, 0, -k.cx, 0}, {0, 0, -1, 0}, {0, k.fy, -k.cy, 0}, {0, 0, -1, 0}};
    case Camera::Model::kOrthographic: {
      const Ray origin = camera.ray_at(0, 0);
      Eigen::Matrix3d axes;
      axes << camera.ray_at(1, 0).origin - origin.origin,
          camera.ray_at(0, 1).origin - origin.origin, origin.direction;
      const Eigen::Matrix3d inverse = axes.inverse();
      RationalProjection projection;
      projection.u_denominator = projection.v_denominator = Eigen::Vector4d::UnitW();
      projection.u_numerator << inverse.row(0).transpose(), -inverse.row(0).dot(origin.origin);
      projection.v_numerator << inverse.row(1).transpose(), -inverse.row(1).dot(origin.origin);
      return projection;
    }
    case Camera::Model::kSpherical:
    case Camera::Model::kRayTable:
      break;
  }
  return camera.projection().value_or(RationalProjection{});
}

double rms_pixels(const Samples& samples, const RationalProjection& projection) {
  double squares = 0.0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const auto pixel = projection.project(samples.points[i]);
    if (!pixel) return std::numeric_limits<double>::infinity();
    squares += (*pixel - samples.pixels[i]).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, samples.points.size())));
}

// The better of the model's own projection and the fitted one.
RationalProjectionFit best_projection(const Samples& samples, const Camera& model) {
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

struct DepthExtent {
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = -std::numeric_limits<double>::infinity();

  void add(double t) {
    nearest = std::min(nearest, t);
    farthest = std::max(farthest, t);
  }
  double length() const { return farthest > nearest ? farthest - nearest : 0.0; }
};

// u and v as affine functions of the point: the projection of an orthographic camera.
std::optional<RationalProjection> fit_affine(const Samples& samples) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> cross = Eigen::Matrix<double, 3, 2>::Zero();
  Eigen::Vector2d pixel_mean = Eigen::Vector2d::Zero();
  for (const auto& pixel : samples.pixels) pixel_mean += pixel;
  pixel_mean /= static_cast<double>(std::max<std::size_t>(1, samples.pixels.size()));
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const Eigen::Vector3d p = samples.points[i] - samples.mean;
    covariance += p * p.transpose();
    cross += p * (samples.pixels[i] - pixel_mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
  // Points in one plane determine no direction of view.
  if (!(eigen.eigenvalues()[0] > 1e-8 * eigen.eigenvalues()[2])) return std::nullopt;
  const Eigen::Matrix<double, 3, 2> slopes = covariance.ldlt().solve(cross);
  RationalProjection projection;
  projection.u_denominator = projection.v_denominator = Eigen::Vector4d::UnitW();
  projection.u_numerator << slopes.col(0), pixel_mean.x() - slopes.col(0).dot(samples.mean);
  projection.v_numerator << slopes.col(1), pixel_mean.y() - slopes.col(1).dot(samples.mean);
  return projection;
}

// pixel = centre + focal * (P[axis] / depth) by linear regression. The focal length is negative
// where the axis of the frame points against the rows or columns.
std::optional<std::pair<double, double>> fit_focal(const Samples& samples, int axis, double sign) {
  double n = 0, s = 0, p = 0, ss = 0, sp = 0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const double depth = sign * samples.points[i].z();
    if (!(depth > 0.0)) return std::nullopt;
    const double slope = samples.points[i][axis] / depth, pixel = samples.pixels[i][axis];
    n += 1, s += slope, p += pixel, ss += slope * slope, sp += slope * pixel;
  }
  const double variance = n * ss - s * s;
  if (!(variance > 0.0)) return std::nullopt;
  const double focal = (n * sp - s * p) / variance;
  if (focal == 0.0 || !std::isfinite(focal)) return std::nullopt;
  return std::pair{focal, (p - focal * s) / n};
}

std::optional<PinholeIntrinsics> fit_intrinsics(const Samples& samples, double sign) {
  const auto x = fit_focal(samples, 0, sign), y = fit_focal(samples, 1, sign);
  if (!x || !y) return std::nullopt;
  return PinholeIntrinsics{x->first, y->first, x->second, y->second};
}

// +1 or -1: the sign with which `direction` leads away from the sensor (see the header).
double away_from_sensor(const Eigen::Vector3d& direction, const GridFile& grid,
                        const Samples& samples, const RationalProjection& projection, double rms) {
  // How many pixels the samples' picture shrinks per unit of depth, times their depth.
  DepthExtent depth, u_extent, v_extent;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    depth.add(samples.points[i].dot(direction));
    u_extent.add(samples.pixels[i].x());
    v_extent.add(samples.pixels[i].y());
  }
  const auto shrinking = [&](const Eigen::Vector4d& denominator) {
    return denominator.head<3>().dot(direction) / denominator.dot(samples.mean.homogeneous());
  };
  const double pixels = depth.length() * 0.5 *
                        (shrinking(projection.u_denominator) * u_extent.length() +
                         shrinking(projection.v_denominator) * v_extent.length());
  if (std::abs(pixels) > 1.0 + 4.0 * rms) return pixels > 0.0 ? 1.0 : -1.0;

  if (normals_tell_side(grid)) {
    std::size_t facing = 0, averted = 0;
    for (const auto& normal : grid.normals) {
      const double cosine = normal.cast<double>().dot(direction);
      if (cosine < 0.0) ++facing;
      if (cosine > 0.0) ++averted;
    }
    if (facing > 3 * averted) return 1.0;
    if (averted > 3 * facing) return -1.0;
  }

  return direction.z() <= 0.0 ? 1.0 : -1.0;
}

std::string vector_text(const Eigen::Vector3d& v) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.4g, %.4g, %.4g)", v.x(), v.y(), v.z());
  return text;
}

std::string residual_text(double rms) {
  char text[64];
  std::snprintf(text, sizeof text, ", residual %.2g pixels RMS", rms);
  return text;
}

struct Candidate {
  FittedCamera fitted;
  double rms = 0.0;
};

void add_pinhole(const Samples& samples, const Grid<Eigen::Vector3d>& points, double sign,
                 std::vector<Candidate>& candidates) {
  const auto k = fit_intrinsics(samples, sign);
  if (!k) return;
  const Camera camera = sign > 0.0 ? Camera::pinhole(points.width(), points.height(), *k)
                                   : Camera::pinhole_gl(points.width(), points.height(), *k);
  char text[160];
  std::snprintf(text, sizeof text, "%s with fx %.6g, fy %.6g, cx %.6g, cy %.6g",
                std::string(to_string(camera.model())).c_str(), k->fx, k->fy, k->cx, k->cy);
  candidates.push_back({{camera, text}, rms_pixels(samples, projection_of(camera))});
}

Candidate orthographic_candidate(const Samples& samples, const GridFile& grid) {
  const auto affine = fit_affine(samples);
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  if (affine)
    direction = affine->u_numerator.head<3>().cross(affine->v_numerator.head<3>()).normalized();
  if (!direction.allFinite()) direction = Eigen::Vector3d::UnitZ();
  RationalProjection parallel;
  parallel.u_denominator = parallel.v_denominator = Eigen::Vector4d::UnitW();
  direction *= away_from_sensor(direction, grid, samples, parallel, 0.0);
  const Camera camera = fit_orthographic(grid.points, direction);
  const double rms = rms_pixels(samples, projection_of(camera));
  return {{camera, "orthographic along " + vector_text(direction)},
          affine ? std::min(rms, rms_pixels(samples, *affine)) : rms};
}

// Angles for every column and row can follow almost any grid: they are taken only where they
// explain the points far better than all models of fewer parameters.
void add_spherical(const Grid<Eigen::Vector3d>& points, std::vector<Candidate>& candidates) {
  double best = kGoodProjectionPixels;
  for (const auto& candidate : candidates) best = std::min(best, candidate.rms);
  auto fit = fit_spherical_projection(points);
  if (!fit || !(fit->rms_pixels < kSphericalGain * best)) return;
  candidates.push_back({{Camera::spherical(std::move(fit->projection)),
                         "spherical (a scanner that turns round its z axis)"},
                        fit->rms_pixels});
}

void add_rational(const Samples& samples, const GridFile& grid,
                  std::vector<Candidate>& candidates) {
  const auto fit = fit_rational_projection(samples.points, samples.pixels);
  if (!fit) return;
  const Eigen::Vector2d centre(0.5 * grid.points.width(), 0.5 * grid.points.height());
  Eigen::Vector3d direction =
      fit->projection.ray(centre.x(), centre.y(), -Eigen::Vector3d::UnitZ()).direction;
  direction *= away_from_sensor(direction, grid, samples, fit->projection, fit->rms_pixels);
  candidates.push_back({{rational_camera(grid.points, fit->projection, direction),
                         "rational projection (line scanner or perspective of any pose) along " +
                             vector_text(direction)},
                        fit->rms_pixels});
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
  result.exact_model =
      model.model() != Camera::Model::kRayTable && largest <= kOnRay * median_spacing(points);
  if (model.model() == Camera::Model::kSpherical) {
    add_spherical_camera(points, model, result);
    return result;
  }
  const Samples samples = collect(points);
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

Camera fit_orthographic(const Grid<Eigen::Vector3d>& points, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d d = direction.normalized();
  const Samples samples = collect(points);
  const auto count = static_cast<Eigen::Index>(samples.points.size());
  Eigen::MatrixX3d design(count, 3), target(count, 3);
  DepthExtent extent;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& p = samples.points[static_cast<std::size_t>(i)];
    extent.add(p.dot(d));
    design.row(i) << 1.0, samples.pixels[static_cast<std::size_t>(i)].transpose();
    target.row(i) = p - p.dot(d) * d;
  }
  // Rows: the origin and the two steps. A single row or column of samples leaves a step open.
  const Eigen::Matrix3d lattice = (design.transpose() * design)
                                      .completeOrthogonalDecomposition()
                                      .solve(design.transpose() * target);
  Eigen::Vector3d step_u = lattice.row(1), step_v = lattice.row(2);
  if (!(step_u.cross(step_v).norm() >
        1e-6 * std::max(step_u.squaredNorm(), step_v.squaredNorm()))) {
    const double length = std::max(step_u.norm(), step_v.norm());
    step_u = d.unitOrthogonal() * (length > 0.0 ? length : 1.0);
    step_v = d.cross(step_u);
  }
  const double standoff = extent.length() > 0.0 ? extent.length() : 1.0;
  const Eigen::Vector3d in_plane = lattice.row(0);
  const Eigen::Vector3d origin =
      in_plane + ((count > 0 ? extent.nearest : 0.0) - standoff - in_plane.dot(d)) * d;
  return Camera::orthographic(points.width(), points.height(), origin, step_u, step_v, d);
}

Camera rational_camera(const Grid<Eigen::Vector3d>& points, const RationalProjection& projection,
                       const Eigen::Vector3d& towards) {
  Grid<Ray> rays(points.width(), points.height());
  DepthExtent extent;
  for (int v = 0; v < rays.height(); ++v) {
    for (int u = 0; u < rays.width(); ++u) {
      rays(u, v) = projection.ray(u, v, towards);
      if (points(u, v).allFinite()) extent.add(rays(u, v).range_of(points(u, v)));
    }
  }
  // The rays may meet at the sensor: stay clear of it.
  const auto in_front = [&](double t) {
    return std::all_of(rays.begin(), rays.end(),
                       [&](const Ray& ray) { return projection.project(ray.at(t)).has_value(); });
  };
  double standoff = extent.length() > 0.0 ? extent.length() : 1.0;
  for (int tries = 0; tries < 10 && !in_front(extent.nearest - standoff); ++tries) standoff *= 0.5;
  for (Ray& ray : rays) ray.origin = ray.at(extent.nearest - standoff);
  return Camera::ray_table(std::move(rays), projection);
}

FittedCamera fit_camera(const GridFile& grid) {
  const Samples samples = collect(grid.points);
  std::vector<Candidate> candidates;
  add_pinhole(samples, grid.points, 1.0, candidates);
  add_pinhole(samples, grid.points, -1.0, candidates);
  candidates.push_back(orthographic_candidate(samples, grid));
  add_rational(samples, grid, candidates);
  add_spherical(grid.points, candidates);
  double best = std::numeric_limits<double>::infinity();
  for (const auto& candidate : candidates) best = std::min(best, candidate.rms);
  for (auto& candidate : candidates) {
    if (candidate.rms > std::max(1.5 * best, 0.02)) continue;
    candidate.fitted.description += residual_text(candidate.rms);
    return candidate.fitted;
  }
  // No residual is finite: parallel rays, which need no fit.
  return orthographic_candidate(samples, grid).fitted;
}

FittedCamera fit_orthographic(const GridFile& grid) {
  Candidate candidate = orthographic_candidate(collect(grid.points), grid);
  candidate.fitted.description += residual_text(candidate.rms);
  return candidate.fitted;
}

}  // namespace relief
