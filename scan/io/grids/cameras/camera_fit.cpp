#include "scan/io/grids/cameras/camera_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include <Eigen/Dense>

#include "scan/base/linear_algebra.h"
#include "scan/io/grids/cameras/grid_samples.h"
#include "scan/io/grids/cameras/normal_side.h"
#include "scan/views/projection_fits.h"

namespace relief {

namespace {

// The residual of a spherical camera over that of the other models: 1.5, as between those (see
// fit_camera), for each of two coordinates, rounded down.
constexpr double kSphericalGain = 0.4;

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
std::optional<RationalProjection> fit_affine(const GridSamples& samples) {
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
  const auto eigen = eigen_decomposition(covariance);
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
std::optional<std::pair<double, double>> fit_focal(const GridSamples& samples, int axis,
                                                   double sign) {
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

std::optional<PinholeIntrinsics> fit_intrinsics(const GridSamples& samples, double sign) {
  const auto x = fit_focal(samples, 0, sign), y = fit_focal(samples, 1, sign);
  if (!x || !y) return std::nullopt;
  return PinholeIntrinsics{x->first, y->first, x->second, y->second};
}

// +1 or -1: the sign with which `direction` leads away from the sensor (see the header).
double away_from_sensor(const Eigen::Vector3d& direction, const GridFile& grid,
                        const GridSamples& samples, const RationalProjection& projection,
                        double rms) {
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

void add_pinhole(const GridSamples& samples, const Grid<Eigen::Vector3d>& points, double sign,
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

Candidate orthographic_candidate(const GridSamples& samples, const GridFile& grid) {
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

void add_rational(const GridSamples& samples, const GridFile& grid,
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

Camera fit_orthographic(const Grid<Eigen::Vector3d>& points, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d d = direction.normalized();
  const GridSamples samples = collect_samples(points);
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
  const GridSamples samples = collect_samples(grid.points);
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
  Candidate candidate = orthographic_candidate(collect_samples(grid.points), grid);
  candidate.fitted.description += residual_text(candidate.rms);
  return candidate.fitted;
}

}  // namespace relief
