#include "registration/calibration/model/corrected_camera.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "relief/scan/projections.h"
#include "scan/views/projection_fits.h"

namespace relief::registration {

namespace {

// Half of the columns that a step between columns is averaged over: a table of rays may go through
// measured points, each with its noise.
constexpr double kHalfStep = 4.0;
// Every so many pixels a sample takes part in the fit of a projection of twelve unknowns.
constexpr int kStride = 4;

double sign_of(int row) { return row % 2 == 0 ? 1.0 : -1.0; }

// Brown's model: what moves the point (x, y) at depth 1 by.
Eigen::Vector2d distortion(const CameraCorrection& correction, double x, double y) {
  const double r = x * x + y * y;
  const double k = correction.radial[0] * r + correction.radial[1] * r * r;
  const double p1 = correction.tangential[0], p2 = correction.tangential[1];
  return {k * x + 2.0 * p1 * x * y + p2 * (r + 2.0 * x * x),
          k * y + p1 * (r + 2.0 * y * y) + 2.0 * p2 * x * y};
}

Camera moved_intrinsics(const Camera& camera, const CameraCorrection& correction) {
  PinholeIntrinsics intrinsics = camera.intrinsics();
  intrinsics.fx *= std::exp(correction.log_focal + correction.log_aspect);
  intrinsics.fy *= std::exp(correction.log_focal - correction.log_aspect);
  intrinsics.cx += correction.principal_point.x();
  intrinsics.cy += correction.principal_point.y();
  return camera.model() == Camera::Model::kPinhole
             ? Camera::pinhole(camera.width(), camera.height(), intrinsics)
             : Camera::pinhole_gl(camera.width(), camera.height(), intrinsics);
}

std::optional<RationalProjection> projection_to(const Grid<Ray>& rays, const RangeView& view) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  for (int v = 0; v < rays.height(); v += kStride) {
    for (int u = 0; u < rays.width(); u += kStride) {
      if (!view.has_sample(u, v)) continue;
      points.push_back(rays(u, v).at(view.range(u, v)));
      pixels.emplace_back(u, v);
    }
  }
  const auto fit = fit_rational_projection(points, pixels);
  return fit ? std::optional(fit->projection) : std::nullopt;
}

template <typename MakeRay>
Camera table_of(const RangeView& view, const MakeRay& make_ray,
                std::optional<RationalProjection> projection = std::nullopt) {
  Grid<Ray> rays(view.width(), view.height());
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u) rays(u, v) = make_ray(u, v);
  if (!projection) projection = projection_to(rays, view);
  return Camera::ray_table(std::move(rays), std::move(projection));
}

Camera undistorted(const RangeView& view, const Camera& camera,
                   const CameraCorrection& correction) {
  return table_of(view, [&](int u, int v) {
    Ray ray = camera.ray(u, v);
    ray.direction.head<2>() += distortion(correction, ray.direction.x(), ray.direction.y());
    return ray;
  });
}

Camera without_interlacing(const RangeView& view, double interlacing) {
  const Camera& camera = view.camera;
  const auto shifted = [&](int u, int v) {
    const double half = 0.5 * interlacing * sign_of(v);
    Ray ray = camera.ray(u, v);
    const Eigen::Vector2d pixel(u, v);
    const Eigen::Vector3d near = column_step(camera, pixel, 0.0);
    ray.origin += half * near;
    ray.direction += half * (column_step(camera, pixel, 1.0) - near);
    return ray;
  };
  return table_of(view, shifted, camera.projection());
}

}  // namespace

void CameraCorrection::add(SensorError error, int index, double value) {
  if (error == SensorError::kFocalLength) log_focal += value;
  if (error == SensorError::kAspectRatio) log_aspect += value;
  if (error == SensorError::kPrincipalPoint) principal_point[index] += value;
  if (error == SensorError::kRadialDistortion) radial[index] += value;
  if (error == SensorError::kTangentialDistortion) tangential[index] += value;
  if (error == SensorError::kInterlacing) interlacing += value;
}

bool CameraCorrection::moves_intrinsics() const {
  return log_focal != 0.0 || log_aspect != 0.0 || !principal_point.isZero(0.0);
}

Camera corrected_camera(const RangeView& view, const CameraCorrection& correction) {
  Camera camera = view.camera;
  if (correction.moves_intrinsics()) camera = moved_intrinsics(camera, correction);
  if (correction.distorts()) camera = undistorted(view, camera, correction);
  if (correction.interlacing != 0.0) camera = without_interlacing(view, correction.interlacing);
  return camera;
}

Eigen::Vector3d column_step(const Camera& camera, const Eigen::Vector2d& pixel, double range) {
  const double last = camera.width() - 1.0;
  const double left = std::clamp(pixel.x() - kHalfStep, 0.0, last);
  const double right = std::clamp(pixel.x() + kHalfStep, 0.0, last);
  if (!(right > left)) return Eigen::Vector3d::Zero();
  return (camera.ray_at(right, pixel.y()).at(range) - camera.ray_at(left, pixel.y()).at(range)) /
         (right - left);
}

}  // namespace relief::registration
