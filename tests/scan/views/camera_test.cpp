#include "relief/scan/camera.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scan/views/projection_fits.h"

namespace relief {
namespace {

void expect_round_trip(const Camera& camera, double t, double tolerance = 1e-9) {
  for (int v = 0; v < camera.height(); v += 7) {
    for (int u = 0; u < camera.width(); u += 5) {
      const auto pixel = camera.project(camera.ray(u, v).at(t));
      ASSERT_TRUE(pixel.has_value());
      EXPECT_NEAR(pixel->x(), u, tolerance);
      EXPECT_NEAR(pixel->y(), v, tolerance);
    }
  }
}

TEST(Camera, PinholeProjectsItsRaysBack) {
  const Camera camera = Camera::pinhole(64, 48, {90, 95, 31.5, 23.5});
  expect_round_trip(camera, 3.0);
  EXPECT_DOUBLE_EQ(camera.ray(10, 20).at(3.0).z(), 3.0);
  EXPECT_FALSE(camera.project({0, 0, -1}).has_value());
}

TEST(Camera, PinholeGlFollowsTheFcConvention) {
  const PinholeIntrinsics k{955.5, 955.5, 456.4, 193.5};
  const Camera camera = Camera::pinhole_gl(512, 384, k);
  expect_round_trip(camera, 2.0);
  const double z = -0.7, u = 100, v = 50;
  const Eigen::Vector3d p(-(u - k.cx) * z / k.fx, -(v - k.cy) * z / k.fy, z);
  EXPECT_LT((camera.ray(100, 50).at(-z) - p).norm(), 1e-12);
}

TEST(Camera, OrthographicProjectsItsRaysBack) {
  const Camera camera =
      Camera::orthographic(32, 24, {-1, 2, 0}, {0.1, 0, 0}, {0, -0.1, 0}, {0, 0, -1});
  expect_round_trip(camera, 5.0);
  expect_round_trip(camera, -5.0);
}

// A laser line scanner that moves along x: u is affine in x, v is perspective in (y, z).
Grid<Ray> line_scanner_rays() {
  Grid<Ray> rays(40, 30);
  for (int v = 0; v < 30; ++v)
    for (int u = 0; u < 40; ++u)
      rays(u, v) = {{0.5 * u, 0, 0}, Eigen::Vector3d(0, (v - 14.5) / 60.0, 1)};
  return rays;
}

TEST(Camera, LineScannerIsARationalProjection) {
  const Grid<Ray> rays = line_scanner_rays();
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 40; ++u) {
      points.push_back(rays(u, v).at(50 + 3 * std::sin(0.7 * u) + 2 * std::cos(0.9 * v)));
      pixels.emplace_back(u, v);
    }
  }
  const auto fit = fit_rational_projection(points, pixels);
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(fit->rms_pixels, 1e-6);
  expect_round_trip(Camera::ray_table(rays, fit->projection), 55.0, 1e-5);

  const Ray fitted = fit->projection.ray(12, 20, {0, 0, 1});
  const Eigen::Vector3d expected = rays(12, 20).direction.normalized();
  EXPECT_LT((fitted.direction - expected).norm(), 1e-6);
  EXPECT_LT((rays(12, 20).origin - fitted.origin).cross(expected).norm(), 1e-5);
}

TEST(Camera, PointsInAPlaneDetermineNoProjection) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  for (int v = 0; v < 10; ++v)
    for (int u = 0; u < 10; ++u) points.emplace_back(u, v, 3), pixels.emplace_back(u, v);
  EXPECT_FALSE(fit_rational_projection(points, pixels).has_value());
}

TEST(Camera, RayTableInterpolatesBetweenPixels) {
  const Camera camera = Camera::ray_table(line_scanner_rays(), std::nullopt);
  EXPECT_FALSE(camera.can_project());
  EXPECT_LT((camera.ray_at(10.5, 3.0).origin - Eigen::Vector3d(5.25, 0, 0)).norm(), 1e-12);
  EXPECT_LT((camera.ray_at(-3.0, 99.0).origin - camera.ray(0, 29).origin).norm(), 1e-12);
}

}  // namespace
}  // namespace relief
