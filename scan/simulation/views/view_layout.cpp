#include "scan/simulation/views/view_layout.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "relief/simulation/simulate.h"
#include "scan/simulation/base/degrees.h"

namespace relief::simulation {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

// Azimuth 0 is -y and grows towards +x.
Eigen::Vector3d from_angles(double azimuth, double elevation) {
  return {std::sin(azimuth) * std::cos(elevation), -std::cos(azimuth) * std::cos(elevation),
          std::sin(elevation)};
}

std::vector<Eigen::Vector3d> turntable_directions(int count) {
  const int cap = count / 6, ring = count - 2 * cap;
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < ring; ++i)
    directions.push_back(from_angles(kTurn * i / ring, radians(i % 2 == 0 ? 20.0 : -10.0)));
  for (const double elevation : {60.0, -60.0})
    for (int i = 0; i < cap; ++i)
      directions.push_back(from_angles(kTurn * (i + 0.25) / cap, radians(elevation)));
  return directions;
}

std::vector<Eigen::Vector3d> sphere_directions(int count) {
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < count; ++i)
    directions.push_back(
        from_angles(kTurn * i / std::numbers::phi, std::asin(1.0 - (2.0 * i + 1.0) / count)));
  return directions;
}

}  // namespace

RigidMotion camera_looking_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const bool vertical = std::hypot(forward.x(), forward.y()) < 1e-9;
  const Eigen::Vector3d up = vertical ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d right = forward.cross(up).normalized();
  RigidMotion world_from_view = RigidMotion::Identity();
  world_from_view.linear() << right, forward.cross(right), forward;
  world_from_view.translation() = eye;
  return world_from_view;
}

std::vector<RigidMotion> layout_poses(ViewLayout layout, int count, const Eigen::Vector3d& target,
                                      double distance) {
  const auto directions =
      layout == ViewLayout::kTurntable ? turntable_directions(count) : sphere_directions(count);
  std::vector<RigidMotion> poses;
  for (const auto& direction : directions)
    poses.push_back(camera_looking_at(target + distance * direction, target));
  return poses;
}

}  // namespace relief::simulation
