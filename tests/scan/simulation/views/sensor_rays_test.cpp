#include "scan/simulation/views/sensor_rays.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "relief/simulation/simulate.h"

namespace relief::simulation {
namespace {

TEST(SensorRays, PixelsHaveTheSpacingAtTheWorkingDistance) {
  constexpr double kFocal = 400.0, kSpacing = 0.05, kDistance = kFocal * kSpacing;
  for (const SensorRays rays :
       {SensorRays::kPinhole, SensorRays::kOrthographic, SensorRays::kLine}) {
    const Camera camera = sensor_camera(rays, 81, 61, kFocal, kSpacing);
    EXPECT_LT((camera.ray(40, 30).at(kDistance) - Eigen::Vector3d(0, 0, kDistance)).norm(), 1e-12);
    for (const auto& [u, v] : {std::pair{0, 0}, {80, 0}, {12, 60}}) {
      const Eigen::Vector3d point = camera.ray(u, v).at(kDistance);
      EXPECT_LT(
          (point - Eigen::Vector3d(kSpacing * (u - 40), kSpacing * (v - 30), kDistance)).norm(),
          1e-12);
      // The range is the depth, and points project to their pixels.
      EXPECT_NEAR(camera.ray(u, v).at(3.0).z(), 3.0, 1e-12);
      const auto pixel = camera.project(camera.ray(u, v).at(7.0));
      ASSERT_TRUE(pixel);
      EXPECT_LT((*pixel - Eigen::Vector2d(u, v)).norm(), 1e-9);
    }
  }
}

TEST(SensorRays, OfALineScannerArePerspectiveAlongTheLineOnly) {
  const Camera camera = sensor_camera(SensorRays::kLine, 81, 61, 400.0, 0.05);
  EXPECT_EQ(camera.ray(3, 7).direction, camera.ray(70, 7).direction);
  EXPECT_NE(camera.ray(3, 7).direction, camera.ray(3, 8).direction);
  EXPECT_EQ(camera.ray(3, 7).origin, camera.ray(3, 50).origin);
}

TEST(SensorRays, OfASphericalScannerGoAllRound) {
  const Camera camera = sensor_camera(SensorRays::kSpherical, 360, 100, 1.0, 1.0);
  const Eigen::Vector3d first = camera.ray(0, 50).direction, last = camera.ray(359, 50).direction;
  EXPECT_NEAR(std::acos(first.dot(last)), std::numbers::pi / 180.0, 1e-3);
  // The top of the picture is up, and columns run clockwise.
  EXPECT_GT(camera.ray(10, 0).direction.z(), camera.ray(10, 99).direction.z());
  const Eigen::Vector3d optical =
      optical_from_sensor(SensorRays::kSpherical) * camera.ray_at(179.5, 49.5).direction;
  EXPECT_LT((optical - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  const Eigen::Vector3d right =
      optical_from_sensor(SensorRays::kSpherical) * camera.ray_at(200, 49.5).direction;
  EXPECT_GT(right.x(), 0.3);
}

}  // namespace
}  // namespace relief::simulation
