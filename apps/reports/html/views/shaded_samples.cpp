#include "apps/reports/html/views/shaded_samples.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

namespace relief {

namespace {

// The steps on the surface from a sample to those right of it and below it.
struct SurfaceSteps {
  Eigen::Vector3d right, down;
};

std::optional<SurfaceSteps> surface_steps(const RangeView& view, int u, int v) {
  if (!view.has_sample(u, v) || !view.has_sample(u + 1, v) || !view.has_sample(u, v + 1))
    return std::nullopt;
  const Eigen::Vector3d here = view.point(u, v);
  return SurfaceSteps{view.point(u + 1, v) - here, view.point(u, v + 1) - here};
}

// The normal of the surface that the sensor sees.
Eigen::Vector3d facing(const SurfaceSteps& steps, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d normal = steps.right.cross(steps.down).normalized();
  return normal.dot(ray) > 0.0 ? Eigen::Vector3d(-normal) : normal;
}

// From the upper left towards the surface's middle, whichever way the grid and the rays go.
Eigen::Vector3d light_of(const RangeView& view, int stride) {
  Eigen::Vector3d right = Eigen::Vector3d::Zero(), down = right, away = right;
  for (int v = 0; v < view.height(); v += stride) {
    for (int u = 0; u < view.width(); u += stride) {
      const auto steps = surface_steps(view, u, v);
      if (!steps) continue;
      right += steps->right.normalized();
      down += steps->down.normalized();
      away -= view.camera.ray(u, v).direction.normalized();
    }
  }
  return (away.normalized() - 0.6 * right.normalized() - 0.6 * down.normalized()).normalized();
}

}  // namespace

rendering::Picture shaded_samples(const RangeView& view, int width) {
  constexpr double kAmbient = 40.0, kLamp = 200.0;  // Of 255.
  const int stride = std::max(1, (view.width() + width - 1) / width);
  rendering::Picture picture((view.width() + stride - 1) / stride,
                             (view.height() + stride - 1) / stride, rendering::kOpaqueWhite);
  const Eigen::Vector3d light = light_of(view, stride);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const int u = x * stride, v = y * stride;
      const auto steps = surface_steps(view, u, v);
      if (!steps) continue;
      const double lit = std::max(0.0, facing(*steps, view.camera.ray(u, v).direction).dot(light));
      const auto grey = static_cast<std::uint8_t>(kAmbient + kLamp * (std::isnan(lit) ? 0.0 : lit));
      picture(x, y) = {grey, grey, grey, 255};
    }
  }
  return picture;
}

}  // namespace relief
