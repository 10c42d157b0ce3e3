#include "scan/simulation/objects/analytic_surface.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "scan/simulation/objects/built_in_object.h"

namespace relief::simulation {
namespace {

Eigen::Vector3d random_vector(std::mt19937& generator) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return {uniform(generator), uniform(generator), uniform(generator)};
}

TEST(Intersect, MatchesTheClosedFormOnASphere) {
  const AnalyticSurface sphere = sphere_surface(2.0);
  std::mt19937 generator(1);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d eye = 8.0 * random_vector(generator).normalized();
    const Ray ray{eye, 3.0 * (2.5 * random_vector(generator) - eye)};
    const double a = ray.direction.squaredNorm(), b = ray.direction.dot(eye);
    const double discriminant = b * b - a * (eye.squaredNorm() - 4.0);
    const auto t = intersect(sphere, ray);
    if (std::abs(discriminant) < 1e-3 * a) continue;  // tangent
    ASSERT_EQ(t.has_value(), discriminant > 0.0);
    if (!t) continue;
    ++hits;
    EXPECT_NEAR(*t, (-b - std::sqrt(discriminant)) / a, 1e-12);
    EXPECT_NEAR(ray.at(*t).norm(), 2.0, 2e-12);
  }
  EXPECT_GT(hits, 500);
}

TEST(Intersect, MissesBehindInsideAndBeside) {
  const AnalyticSurface sphere = sphere_surface(1.0);
  EXPECT_FALSE(intersect(sphere, {{0, 0, -5}, {0, 0, -1}}));
  EXPECT_FALSE(intersect(sphere, {{0, 0, 0}, {0, 0, 1}}));
  EXPECT_FALSE(intersect(sphere, {{1.5, 0, -5}, {0, 0, 1}}));
  EXPECT_TRUE(intersect(sphere, {{0.5, 0, -5}, {0, 0, 1}}));
}

// Dense marching, with no use of the Lipschitz constant, must not find an earlier entry.
TEST(Intersect, FindsTheFirstEntryIntoTheBuiltInObject) {
  const AnalyticSurface owl = built_in_object();
  std::mt19937 generator(2);
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d eye = 400.0 * random_vector(generator).normalized();
    const Ray ray{eye, (55.0 * random_vector(generator) - eye).normalized()};
    std::optional<double> dense;
    const double step = 0.02;
    for (double t = 330.0; t < 470.0 && !dense; t += step)
      if (owl.value(ray.at(t)) <= 0.0) dense = t;
    const auto t = intersect(owl, ray);
    ASSERT_TRUE(t || !dense) << "missed at ray " << i;
    if (!t) continue;
    ++hits;
    EXPECT_LT(std::abs(owl.value(ray.at(*t))), 1e-10);
    if (dense) {
      EXPECT_LE(*t, *dense + 1e-9);
    }
    if (dense && owl.gradient(ray.at(*t)).dot(ray.direction) < -0.3) {
      EXPECT_GT(*t, *dense - step - 1e-9);
    }
  }
  EXPECT_GT(hits, 100);
}

}  // namespace
}  // namespace relief::simulation
