#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "relief/scan/camera.h"
#include "relief/scan/projections.h"
#include "scan/views/projection_fits.h"
#include "tests/support/result_matchers.h"

namespace relief {
namespace {

constexpr double kPi = std::numbers::pi;

SphericalProjection whole_turn() {
  return SphericalProjection::even(360, 120, kPi - 0.01, -2.0 * kPi / 360, 1.2, -0.02);
}

// Angles whose steps differ by a third.
SphericalProjection uneven() {
  SphericalProjection angles;
  for (int u = 0; u < 90; ++u) angles.azimuth.push_back(2.0 + 0.02 * (u + std::sin(u) / 3.0));
  for (int v = 0; v < 70; ++v) angles.elevation.push_back(0.9 - 0.02 * (v + std::cos(v) / 3.0));
  return angles;
}

Grid<Eigen::Vector3d> points_on(const SphericalProjection& angles) {
  const Camera camera = Camera::spherical(angles);
  Grid<Eigen::Vector3d> points(camera.width(), camera.height(), Eigen::Vector3d::Zero());
  for (int v = 0; v < points.height(); ++v)
    for (int u = 0; u < points.width(); ++u)
      points(u, v) = camera.ray(u, v).at(4.0 + std::sin(0.1 * u) + std::cos(0.07 * v));
  return points;
}

void expect_projects_back(const SphericalProjection& angles) {
  const Camera camera = Camera::spherical(angles);
  EXPECT_TRUE(camera.can_project());
  for (double v = 0.0; v < camera.height() - 1.0; v += 3.3) {
    for (double u = 0.0; u < camera.width() - 1.0; u += 5.7) {
      const Ray ray = camera.ray_at(u, v);
      EXPECT_NEAR(ray.direction.norm(), 1.0, 1e-15);
      const auto pixel = camera.project(ray.at(2.5));
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->x(), u, 1e-9);
      EXPECT_NEAR(pixel->y(), v, 1e-9);
    }
  }
}

TEST(SphericalProjection, ProjectsItsRaysBack) {
  expect_projects_back(whole_turn());
  expect_projects_back(uneven());
}

TEST(SphericalProjection, HasTheDirectionsOfItsFormula) {
  const SphericalProjection angles = SphericalProjection::even(10, 8, 0.3, 0.1, -0.2, 0.05);
  const Eigen::Vector3d d = Camera::spherical(angles).ray(4, 6).direction;
  EXPECT_NEAR(d.x(), std::cos(0.1) * std::cos(0.7), 1e-15);
  EXPECT_NEAR(d.y(), std::cos(0.1) * std::sin(0.7), 1e-15);
  EXPECT_NEAR(d.z(), std::sin(0.1), 1e-15);
}

TEST(SphericalProjection, PutsPointsOutsideOfTheGridBeyondItsEnds) {
  const SphericalProjection angles = SphericalProjection::even(11, 11, -0.5, 0.1, -0.5, 0.1);
  EXPECT_NEAR(angles.project(angles.ray(-2.0, 5.0).at(1.0))->x(), -2.0, 1e-9);
  EXPECT_NEAR(angles.project(angles.ray(5.0, 12.5).at(1.0))->y(), 12.5, 1e-9);
  EXPECT_FALSE(angles.project({0.0, 0.0, 2.0}));
  // Behind the sensor is half a turn away.
  EXPECT_GT(std::abs(angles.project({-1.0, 0.01, 0.0})->x() - 5.0), 30.0);
}

TEST(SphericalProjection, RefusesAnglesThatAreNoGrid) {
  EXPECT_TRUE(whole_turn().valid());
  EXPECT_FALSE(SphericalProjection::even(1, 5, 0.0, 0.1, 0.0, 0.1).valid());
  EXPECT_FALSE(SphericalProjection::even(5, 5, 0.0, 0.0, 0.0, 0.1).valid());
  EXPECT_FALSE(SphericalProjection::even(5, 5, 0.0, 2.0, 0.0, 0.1).valid());
  EXPECT_FALSE(SphericalProjection::even(5, 5, 0.0, 0.1, 1.4, 0.1).valid());
  EXPECT_FALSE(SphericalProjection::even(5, 5, std::nan(""), 0.1, 0.0, 0.1).valid());
}

TEST(SphericalProjection, IsFoundFromPoints) {
  for (const SphericalProjection& angles : {whole_turn(), uneven()}) {
    const auto fit = value_of(fit_spherical_projection(points_on(angles)));
    EXPECT_LT(fit.rms_pixels, 1e-6);
    for (std::size_t u = 0; u < angles.azimuth.size(); ++u)
      EXPECT_NEAR(std::remainder(fit.projection.azimuth[u] - angles.azimuth[u], 2.0 * kPi), 0.0,
                  1e-9);
  }
}

TEST(SphericalProjection, IsFoundWithHolesAndNoise) {
  Grid<Eigen::Vector3d> points = points_on(whole_turn());
  std::mt19937 generator(3);
  std::normal_distribution<double> noise(0.0, 0.002);
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      points(u, v) += Eigen::Vector3d(noise(generator), noise(generator), noise(generator));
      const bool missing = (u > 40 && u < 60) || v < 5 || (u + v) % 7 == 0;
      if (missing) points(u, v).setConstant(std::nan(""));
    }
  }
  const auto fit = value_of(fit_spherical_projection(points));
  EXPECT_LT(fit.rms_pixels, 0.1);
  const auto pixel = fit.projection.project(whole_turn().ray(50, 60).at(3.0));
  EXPECT_NEAR(pixel->x(), 50.0, 0.05);
  EXPECT_NEAR(pixel->y(), 60.0, 0.05);
}

TEST(SphericalProjection, IsNotFoundInAGridOfAnotherSensor) {
  Grid<Eigen::Vector3d> points(40, 30, Eigen::Vector3d::Constant(std::nan("")));
  EXPECT_FALSE(fit_spherical_projection(points));
  // Parallel rays: the angles of a row depend on the column.
  for (int v = 0; v < 30; ++v)
    for (int u = 0; u < 40; ++u) points(u, v) = {5.0 + std::sin(u + v), 0.1 * u, 0.1 * v};
  const auto fit = fit_spherical_projection(points);
  EXPECT_TRUE(!fit || fit->rms_pixels > 0.5);
}

}  // namespace
}  // namespace relief
