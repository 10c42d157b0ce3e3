#include "scan/rendering/rays/ambient_openness.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "scan/base/counter_random.h"

namespace relief::rendering {

namespace {

// Maps the unit square to the half sphere round z with density cos / pi (Malley's method).
Eigen::Vector3d cosine_weighted(double a, double b) {
  const double radius = std::sqrt(a), angle = 2.0 * std::numbers::pi * b;
  return {radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1.0 - a)};
}

Eigen::Matrix3d frame_round(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d across = normal.unitOrthogonal();
  Eigen::Matrix3d frame;
  frame << across, normal.cross(across), normal;
  return frame;
}

}  // namespace

double ambient_openness(const RayCaster& caster, const Eigen::Vector3d& point,
                        const Eigen::Vector3d& normal, const Eigen::Vector3d& side,
                        const SkyRays& rays, std::uint64_t stream) {
  const CounterRandom random(rays.seed, stream);
  const Eigen::Matrix3d world_from_sky = frame_round(normal);
  const double cell = 1.0 / rays.per_side;
  std::uint64_t drawn = 0;
  int open = 0;
  for (int i = 0; i < rays.per_side; ++i) {
    for (int j = 0; j < rays.per_side; ++j) {
      const double a = (i + random.uniform(drawn++)) * cell;
      const double b = (j + random.uniform(drawn++)) * cell;
      Eigen::Vector3d direction = world_from_sky * cosine_weighted(a, b);
      const double above = direction.dot(side);
      if (above < 0.0) direction -= 2.0 * above * side;
      open += caster.is_blocked(point, side, direction, rays.reach) ? 0 : 1;
    }
  }
  return static_cast<double>(open) / (rays.per_side * rays.per_side);
}

}  // namespace relief::rendering
