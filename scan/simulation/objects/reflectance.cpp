#include "scan/simulation/objects/reflectance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "relief/simulation/simulation_object.h"
#include "scan/simulation/base/degrees.h"
#include "scan/simulation/base/option_check.h"

namespace relief::simulation {

namespace {

// The level that a standard normal number exceeds with the given probability, by bisection.
double upper_quantile(double probability) {
  double low = -40.0, high = 40.0;
  while (high - low > 1e-12) {
    const double middle = 0.5 * (low + high);
    const double above = 0.5 * std::erfc(middle / std::numbers::sqrt2);
    (above > probability ? low : high) = middle;
  }
  return low;
}

// 0 to 1 across the level; half of the width on either side.
double soft_step(double value, double level) {
  // [standard deviations of the field] Soft borders of about 3 % of a wavelength: 0.1 over the
  // field's gradient, sqrt(2/3) 2 pi / 1.5.
  constexpr double kWidth = 0.1;
  const double x = std::clamp((value - level) / kWidth + 0.5, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

double standard_at(const PlaneWaves& field, const Eigen::Vector3d& point) {
  return field.scalar_at(point) / std::sqrt(field.scalar_variance());
}

PlaneWaves patch_field(const Reflectance& reflectance, double diameter,
                       const RandomStream& random) {
  return PlaneWaves(reflectance.patch_size * diameter, CounterRandom(random.seed, random.stream));
}

}  // namespace

Reflectance patchy_surface() {
  Reflectance reflectance;
  reflectance.dark_fraction = 0.1;
  reflectance.glossy_fraction = 0.1;
  return reflectance;
}

Result<void> validate(const Reflectance& r) {
  const auto fraction = [](double x) { return x >= 0.0 && x < 1.0; };
  return first_failure(
      {require(fraction(r.dark_fraction), "dark_fraction", r.dark_fraction, "in [0, 1)"),
       require(r.dark_albedo > 0.0 && r.dark_albedo <= 1.0, "dark_albedo", r.dark_albedo,
               "in (0, 1]"),
       require(fraction(r.glossy_fraction), "glossy_fraction", r.glossy_fraction, "in [0, 1)"),
       require_positive("patch_size", r.patch_size),
       require(r.highlight_width_deg > 0.0 && r.highlight_width_deg < 90.0, "highlight_width_deg",
               r.highlight_width_deg, "in (0, 90)"),
       require_not_negative("highlight_strength", r.highlight_strength)});
}

PaintedSurface::PaintedSurface(const Reflectance& reflectance, double diameter,
                               const RandomStream& dark_random, const RandomStream& gloss_random)
    : reflectance_(reflectance),
      highlight_width_(radians(reflectance.highlight_width_deg)),
      dark_level_(upper_quantile(reflectance.dark_fraction)),
      gloss_level_(upper_quantile(reflectance.glossy_fraction)),
      dark_field_(patch_field(reflectance, diameter, dark_random)),
      gloss_field_(patch_field(reflectance, diameter, gloss_random)) {}

SurfacePaint PaintedSurface::at(const Eigen::Vector3d& point) const {
  SurfacePaint paint;
  if (reflectance_.dark_fraction > 0.0) {
    const double dark = soft_step(standard_at(dark_field_, point), dark_level_);
    paint.albedo = 1.0 - dark * (1.0 - reflectance_.dark_albedo);
  }
  if (reflectance_.glossy_fraction > 0.0)
    paint.gloss = soft_step(standard_at(gloss_field_, point), gloss_level_);
  return paint;
}

// Equation (S10): Lambert's law and a highlight round the half vector (Blinn 1977) of Gaussian
// profile (Ward 1992).
double PaintedSurface::reflected(const SurfacePaint& paint, const Eigen::Vector3d& normal,
                                 const Eigen::Vector3d& to_light,
                                 const Eigen::Vector3d& to_viewer) const {
  const double cosine = normal.dot(to_light);
  if (cosine <= 0.0) return 0.0;
  double light = paint.albedo * cosine;
  if (paint.gloss > 0.0) {
    const Eigen::Vector3d half = to_light + to_viewer;
    const double angle = std::atan2(normal.cross(half).norm(), normal.dot(half));
    const double x = angle / highlight_width_;
    light += reflectance_.highlight_strength * paint.gloss * std::exp(-x * x);
  }
  return light;
}

}  // namespace relief::simulation
