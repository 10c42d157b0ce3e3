#include "scan/simulation/defects/glare.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "relief/simulation/scan_defects.h"
#include "scan/simulation/base/degrees.h"
#include "scan/simulation/base/for_each_sample.h"
#include "scan/simulation/base/option_check.h"
#include "scan/simulation/defects/scan_defects.h"
#include "scan/simulation/sensors/pixel_noise.h"
#include "scan/simulation/sensors/sensor_errors.h"

namespace relief::simulation {

namespace {

// [pixels], of g in (S18). A free choice of the scene: as the noise of the laser line.
constexpr double kCorrelation = 3.0;

std::vector<Eigen::Vector3d> lamp_directions(const Glare& glare) {
  std::vector<Eigen::Vector3d> lamps;
  const double angle = radians(glare.lamp_angle_deg);
  for (int k = 0; k < glare.lamps; ++k) {
    // The first stands half right above, so that no image axis is special.
    const double turn = 2.0 * std::numbers::pi * (k - 0.125) / glare.lamps;
    lamps.emplace_back(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn),
                       -std::cos(angle));
  }
  return lamps;
}

// The strongest highlight of a point, in [0, 1], and the lamp that makes it.
struct Highlight {
  double strength = 0.0;
  Eigen::Vector3d lamp = Eigen::Vector3d::Zero();
};

Highlight highlight(const std::vector<Eigen::Vector3d>& lamps, const Eigen::Vector3d& normal,
                    const Eigen::Vector3d& to_viewer, double width) {
  Highlight strongest;
  for (const Eigen::Vector3d& lamp : lamps) {
    const Eigen::Vector3d half = (lamp + to_viewer).normalized();
    const double angle = std::atan2(normal.cross(half).norm(), normal.dot(half)) / width;
    const double strength = std::exp(-angle * angle);
    if (strength > strongest.strength) strongest = {strength, lamp};
  }
  return strongest;
}

}  // namespace

Result<void> validate(const Glare& glare) {
  const auto angle = [](double x) { return x > 0.0 && x < 90.0; };
  return first_failure(
      {require(glare.lamps >= 1 && glare.lamps <= 64, "glare lamps", glare.lamps, "in [1, 64]"),
       require(angle(glare.lamp_angle_deg), "glare lamp_angle_deg", glare.lamp_angle_deg,
               "in (0, 90)"),
       require(angle(glare.width_deg), "glare width_deg", glare.width_deg, "in (0, 90)"),
       require_not_negative("glare range_error", glare.range_error)});
}

// Equations (S17) and (S18).
void add_glare(RangeView& view, const Glare& glare, const SensorScene& scene) {
  const std::vector<Eigen::Vector3d> lamps = lamp_directions(glare);
  const Grid<double> noise =
      pixel_noise(view.width(), view.height(), kCorrelation, scene.of_view(kGlareNoise));
  const double width = radians(glare.width_deg), size = glare.range_error * scene.spacing;
  for_each_sample(view, [&](int u, int v) {
    if (scene.sees_background(u, v)) return;
    const Eigen::Vector3d direction = view.camera.ray(u, v).direction;
    const Highlight found =
        highlight(lamps, scene.truth.normals(u, v).cast<double>(), -direction.normalized(), width);
    view.range(u, v) += size * found.strength * noise(u, v) / direction.norm();
    if (!view.has_normal(u, v)) return;
    const Eigen::Vector3d leaning =
        (1.0 - found.strength) * view.normals(u, v).cast<double>() + found.strength * found.lamp;
    view.normals(u, v) = facing_sensor(leaning.normalized(), direction);
  });
}

}  // namespace relief::simulation
