#include "scan/rendering/rays/ambient_openness.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/scan/rendering/shapes.h"
#include "tests/support/result_matchers.h"

namespace relief::rendering {
namespace {

using testing::floor_and_wall;
using testing::plate;
using testing::sphere;

const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

// Five standard deviations of a share of independent rays; stratified ones scatter less.
double tolerance(double share, const SkyRays& rays) {
  return 5.0 * std::sqrt(share * (1.0 - share)) / rays.per_side;
}

double openness(const TriangleMesh& mesh, const Eigen::Vector3d& point, const SkyRays& rays) {
  return ambient_openness(*RayCaster::of(mesh), point, kUp, kUp, rays, 7);
}

TEST(AmbientOpenness, AFlatPlaneIsFullyOpen) {
  const SkyRays rays{.per_side = 32, .reach = 100.0};
  EXPECT_EQ(openness(plate(10.0, 8), {0.1, 0.2, 0.0}, rays), 1.0);
}

TEST(AmbientOpenness, TheCornerOfTwoPlanesIsHalfOpen) {
  const SkyRays rays{.per_side = 64, .reach = 1e9};
  EXPECT_NEAR(openness(floor_and_wall(1000.0), {0.0, -0.1, 0.0}, rays), 0.5, tolerance(0.5, rays));
}

TEST(AmbientOpenness, AWallTakesWhatItsViewFactorSays) {
  // At distance d from an endless wall of height h: (1 + d / sqrt(d^2 + h^2)) / 2 is open.
  const SkyRays rays{.per_side = 64, .reach = 1e9};
  const double expected = 0.5 * (1.0 + 1.0 / std::sqrt(2.0));
  TriangleMesh mesh = floor_and_wall(1000.0);
  for (auto& vertex : mesh.vertices)
    if (vertex.z() > 0.0) vertex.z() = 3.0;
  EXPECT_NEAR(openness(mesh, {0.0, -3.0, 0.0}, rays), expected, tolerance(expected, rays));
}

TEST(AmbientOpenness, WhatIsBeyondTheReachDoesNotBlock) {
  const TriangleMesh mesh = floor_and_wall(1000.0);
  EXPECT_EQ(openness(mesh, {0.0, -3.0, 0.0}, {.per_side = 16, .reach = 2.9}), 1.0);
  EXPECT_LT(openness(mesh, {0.0, -3.0, 0.0}, {.per_side = 16, .reach = 30.0}), 0.8);
}

TEST(AmbientOpenness, FacetsOfAConvexSurfaceDoNotBlockEachOther) {
  const TriangleMesh ball = sphere(1.0, {0, 0, 0}, 4);
  const auto caster = value_of(RayCaster::of(ball));
  for (std::size_t f = 0; f < ball.faces.size(); ++f) {
    const Eigen::Vector3d side = face_cross(ball, f).normalized();
    // Near a corner the normal that shades differs most from that of the face.
    const Eigen::Vector3d point =
        0.8 * ball.corner(f, 0) + 0.1 * ball.corner(f, 1) + 0.1 * ball.corner(f, 2);
    EXPECT_EQ(
        ambient_openness(caster, point, point.normalized(), side, {.per_side = 8, .reach = 1.0}, f),
        1.0);
  }
}

TEST(AmbientOpenness, DependsOnTheStreamOnly) {
  const auto caster = value_of(RayCaster::of(floor_and_wall(1000.0)));
  const SkyRays rays{.per_side = 4, .reach = 1e9};
  const auto at = [&](std::uint64_t stream) {
    return ambient_openness(caster, {0.0, -300.0, 0.0}, kUp, kUp, rays, stream);
  };
  EXPECT_EQ(at(3), at(3));
  bool differs = false;
  for (std::uint64_t stream = 0; stream < 20; ++stream) differs |= at(stream) != at(3);
  EXPECT_TRUE(differs);
}

}  // namespace
}  // namespace relief::rendering
