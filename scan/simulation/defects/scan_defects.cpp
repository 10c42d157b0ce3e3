#include "relief/simulation/scan_defects.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "scan/base/counter_random.h"
#include "scan/simulation/base/for_each_sample.h"
#include "scan/simulation/base/option_check.h"
#include "scan/simulation/defects/background_plate.h"
#include "scan/simulation/defects/calibration_warp.h"
#include "scan/simulation/defects/glare.h"
#include "scan/simulation/defects/scan_defects.h"

namespace relief::simulation {

namespace {

CounterRandom random_of(const SensorScene& scene, SensorErrorKind kind) {
  const RandomStream stream = scene.of_view(kind);
  return {stream.seed, stream.stream};
}

// The smooth error of one view, scaled to RMS 1 over its samples.
Grid<double> view_warp_field(const RangeView& view, const SensorScene& scene) {
  const CalibrationWarp warp(scene.of_view(kViewWarp));
  Grid<double> field(view.width(), view.height(), 0.0);
  double squares = 0.0, count = 0.0;
  for_each_sample_in_order(view, [&](int u, int v) {
    field(u, v) = warp.at(image_coordinate(u, view.width()), image_coordinate(v, view.height()));
    squares += field(u, v) * field(u, v);
    count += 1.0;
  });
  if (squares > 0.0)
    for (double& value : field) value /= std::sqrt(squares / count);
  return field;
}

void add_view_warp(RangeView& view, double size, const SensorScene& scene) {
  const Grid<double> field = view_warp_field(view, scene);
  for_each_sample(view, [&](int u, int v) { view.range(u, v) += size * field(u, v); });
}

void throw_off(RangeView& view, const ScanDefects& defects, const SensorScene& scene) {
  const CounterRandom random = random_of(scene, kOutliers);
  const double size = defects.outlier_distance * scene.spacing;
  for_each_sample(view, [&](int u, int v) {
    const std::size_t pixel = view.range.index(u, v);
    if (random.uniform(4 * pixel) >= defects.outlier_fraction) return;
    const double range = view.range[pixel] + size * random.normal(2 * pixel + 1) /
                                                 view.camera.ray(u, v).direction.norm();
    if (range > 0.0) view.range[pixel] = range;
  });
}

void quantise(RangeView& view, double step) {
  for_each_sample(
      view, [&](int u, int v) { view.range(u, v) = step * std::round(view.range(u, v) / step); });
}

void lose_at_random(RangeView& view, double fraction, const SensorScene& scene) {
  const CounterRandom random = random_of(scene, kMissingSamples);
  for_each_sample(view, [&](int u, int v) {
    if (random.uniform(view.range.index(u, v)) < fraction) lose_sample(view, u, v);
  });
}

Eigen::Vector3f mistaken(const Eigen::Vector3f& n, NormalMistake mistake,
                         const RigidMotion& world_from_view) {
  switch (mistake) {
    case NormalMistake::kNone:
      return n;
    case NormalMistake::kFlipX:
      return {-n.x(), n.y(), n.z()};
    case NormalMistake::kFlipY:
      return {n.x(), -n.y(), n.z()};
    case NormalMistake::kFlipZ:
      return {n.x(), n.y(), -n.z()};
    case NormalMistake::kSwapXY:
      return {n.y(), n.x(), n.z()};
    case NormalMistake::kWorldSpace:
      return (world_from_view.linear() * n.cast<double>()).cast<float>();
  }
  return n;
}

}  // namespace

Result<void> validate(const ScanDefects& d) {
  if (d.background)
    if (auto checked = validate(*d.background); !checked) return checked;
  if (d.glare)
    if (auto checked = validate(*d.glare); !checked) return checked;
  return first_failure(
      {require_positive("noise_half", d.noise_half), require_not_negative("view_warp", d.view_warp),
       require(d.outlier_fraction >= 0.0 && d.outlier_fraction <= 1.0, "outlier_fraction",
               d.outlier_fraction, "in [0, 1]"),
       require_not_negative("outlier_distance", d.outlier_distance),
       require_not_negative("quantisation", d.quantisation),
       require(d.missing_fraction >= 0.0 && d.missing_fraction < 1.0, "missing_fraction",
               d.missing_fraction, "in [0, 1)"),
       require_positive("focal_factor", d.focal_factor),
       require_positive("scale_factor", d.scale_factor),
       require(d.radial_distortion > -1.0 / 3.0 && d.radial_distortion < 1.0, "radial_distortion",
               d.radial_distortion, "in (-1/3, 1)"),
       require(std::isfinite(d.range_offset), "range_offset", d.range_offset, "finite")});
}

void spoil_view(RangeView& view, const ScanDefects& defects, const SensorScene& scene) {
  if (defects.view_warp > 0.0) add_view_warp(view, defects.view_warp * scene.spacing, scene);
  if (defects.glare) add_glare(view, *defects.glare, scene);
  if (defects.outlier_fraction > 0.0) throw_off(view, defects, scene);
  if (defects.quantisation > 0.0) quantise(view, defects.quantisation * scene.spacing);
  if (defects.missing_fraction > 0.0) lose_at_random(view, defects.missing_fraction, scene);
}

void mistake_normals(RangeView& view, NormalMistake mistake, const RigidMotion& world_from_view) {
  if (mistake == NormalMistake::kNone) return;
  for (Eigen::Vector3f& normal : view.normals) normal = mistaken(normal, mistake, world_from_view);
}

// Along a ray x = X / Z is undistorted: x_true = x (1 + k1 r^2) (Brown 1971).
Camera true_camera(const Camera& stated, const ScanDefects& defects) {
  if (defects.radial_distortion == 0.0) return stated;
  const auto square = [&](int u, int v) {
    return stated.ray(u, v).direction.head<2>().squaredNorm();
  };
  const int right = stated.width() - 1, bottom = stated.height() - 1;
  const double corner =
      std::max({square(0, 0), square(right, 0), square(0, bottom), square(right, bottom)});
  Grid<Ray> rays(stated.width(), stated.height());
  for (int v = 0; v <= bottom; ++v) {
    for (int u = 0; u <= right; ++u) {
      rays(u, v) = stated.ray(u, v);
      rays(u, v).direction.head<2>() *= 1.0 + defects.radial_distortion * square(u, v) / corner;
    }
  }
  return Camera::ray_table(std::move(rays), std::optional<RationalProjection>());
}

void miscalibrate(RangeView& view, const Camera& stated, const ScanDefects& defects,
                  double spacing) {
  if (defects.radial_distortion != 0.0) view.camera = stated;
  if (defects.focal_factor != 1.0) {
    PinholeIntrinsics wrong = stated.intrinsics();
    wrong.fx *= defects.focal_factor;
    wrong.fy *= defects.focal_factor;
    view.camera = Camera::pinhole(view.width(), view.height(), wrong);
  }
  if (defects.scale_factor != 1.0)
    for_each_sample(view, [&](int u, int v) { view.range(u, v) *= defects.scale_factor; });
  if (defects.range_offset != 0.0)
    for_each_sample(view, [&](int u, int v) {
      view.range(u, v) += defects.range_offset * spacing / view.camera.ray(u, v).direction.norm();
    });
}

}  // namespace relief::simulation
