#include <algorithm>
#include <cmath>
#include <numbers>

#include "scan/rendering/rays/ambient_openness.h"
#include "scan/rendering/styles/paint.h"

namespace relief::rendering {

namespace {

const LinearColour kClay(0.80, 0.78, 0.74), kBack(0.42, 0.20, 0.11);
constexpr double kAmbient = 0.03;  // Fraction of the light: shadow is byte 48 of white, not black.
// Of accessibility: bytes are in proportion to what is open, so grooves stand out.
// sRGB is near to the inverse.
constexpr double kGamma = 2.2;

const LinearColour& matter(const VisiblePoint& point) { return point.back ? kBack : kClay; }

Eigen::Vector3d towards_light(const PaintContext& context, const LightDirection& light) {
  const double azimuth = light.azimuth_deg * std::numbers::pi / 180.0;
  const double elevation = light.elevation_deg * std::numbers::pi / 180.0;
  const Eigen::Vector3d in_picture(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                                   std::cos(azimuth) * std::cos(elevation));
  return context.picture_axes.transpose() * in_picture;
}

double lambert(const Eigen::Vector3d& normal, const Eigen::Vector3d& towards) {
  return std::max(0.0, normal.dot(towards));
}

// Cells on each side so that the rays of a pixel together are as many as asked for.
int cells_per_side(const RenderOptions& options) {
  const double rays_each =
      static_cast<double>(options.ambient_rays) / (options.antialiasing * options.antialiasing);
  return std::max(1, static_cast<int>(std::ceil(std::sqrt(rays_each) - 1e-9)));
}

}  // namespace

double soft_light(const PaintContext& context, const VisiblePoint& point) {
  const Eigen::Vector3d viewer = context.picture_axes.row(2).transpose();
  return 0.45 + 0.55 * lambert(point.normal, viewer);
}

StylePaint lit_paint(const PaintContext& context, const LightDirection& light, double fill) {
  const Eigen::Vector3d key = towards_light(context, light);
  const Eigen::Vector3d viewer = context.picture_axes.row(2).transpose();
  return {[=](const VisiblePoint& point) -> LinearColour {
            const double lit = (1.0 - kAmbient - fill) * lambert(point.normal, key) +
                               fill * lambert(point.normal, viewer) + kAmbient;
            return lit * matter(point);
          },
          std::nullopt};
}

StylePaint accessibility_paint(const PaintContext& context) {
  const SkyRays rays{.per_side = cells_per_side(context.options),
                     .reach = context.options.ambient_reach * context.diagonal,
                     .seed = context.options.seed};
  return {[&caster = context.caster, rays](const VisiblePoint& point) -> LinearColour {
            const double open = ambient_openness(caster, point.place, point.normal,
                                                 point.face_normal, rays, point.stream);
            return matter(point) * std::pow(open, kGamma);
          },
          std::nullopt};
}

StylePaint normal_paint(const PaintContext& context) {
  return {[axes = context.picture_axes](const VisiblePoint& point) -> LinearColour {
            const Eigen::Array3d bytes = 127.5 * ((axes * point.normal).array() + 1.0);
            const auto byte = [&](int k) {
              return static_cast<std::uint8_t>(std::lround(bytes[k]));
            };
            return linear_of(Colour{byte(0), byte(1), byte(2)});
          },
          std::nullopt};
}

StylePaint colour_paint(const PaintContext& context) {
  return {[&mesh = context.mesh](const VisiblePoint& point) -> LinearColour {
            LinearColour colour = LinearColour::Zero();
            for (int k = 0; k < 3; ++k)
              colour += point.weights[k] * linear_of(mesh.colours[mesh.faces[point.face][k]]);
            return colour;
          },
          std::nullopt};
}

}  // namespace relief::rendering
