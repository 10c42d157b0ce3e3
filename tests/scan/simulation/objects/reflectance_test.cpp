#include "scan/simulation/objects/reflectance.h"

#include <cmath>

#include <gtest/gtest.h>

#include "relief/simulation/simulation_object.h"
#include "tests/support/result_matchers.h"

namespace relief::simulation {
namespace {

PaintedSurface painted(const Reflectance& reflectance, double diameter = 1.0) {
  return PaintedSurface(reflectance, diameter, {1, 1}, {1, 2});
}

TEST(PaintedSurface, IsWhiteAndDiffuseByDefault) {
  const SurfacePaint paint = painted({}).at({0.1, 0.2, 0.3});
  EXPECT_EQ(paint.albedo, 1.0);
  EXPECT_EQ(paint.gloss, 0.0);
}

TEST(PaintedSurface, HasTheStatedPartsDarkAndGlossy) {
  Reflectance reflectance;
  reflectance.dark_fraction = 0.2;
  reflectance.glossy_fraction = 0.3;
  reflectance.dark_albedo = 0.05;
  const PaintedSurface surface = painted(reflectance);
  double dark = 0.0, glossy = 0.0;
  constexpr int kCount = 40;
  for (int i = 0; i < kCount * kCount * kCount; ++i) {
    const Eigen::Vector3d point(i % kCount, i / kCount % kCount, i / kCount / kCount);
    const SurfacePaint paint = surface.at(0.23 * point);
    EXPECT_GE(paint.albedo, 0.05 - 1e-12);
    EXPECT_LE(paint.albedo, 1.0);
    dark += paint.albedo < 0.525;
    glossy += paint.gloss > 0.5;
  }
  EXPECT_NEAR(dark / std::pow(kCount, 3), 0.2, 0.03);
  EXPECT_NEAR(glossy / std::pow(kCount, 3), 0.3, 0.03);
}

TEST(PaintedSurface, ScalesWithTheObject) {
  Reflectance reflectance = patchy_surface();
  const PaintedSurface small = painted(reflectance, 1.0), large = painted(reflectance, 1000.0);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d point(0.013 * i, std::sin(i), 0.3);
    EXPECT_NEAR(small.at(point).albedo, large.at(1000.0 * point).albedo, 1e-9);
    EXPECT_NEAR(small.at(point).gloss, large.at(1000.0 * point).gloss, 1e-9);
  }
}

TEST(PaintedSurface, ReflectsByLambertsLawAndAHighlight) {
  Reflectance reflectance;
  reflectance.highlight_width_deg = 10.0;
  reflectance.highlight_strength = 3.0;
  const PaintedSurface surface = painted(reflectance);
  const Eigen::Vector3d normal(0, 0, 1), viewer(0, 0, 1);
  const double turn = 20.0 * std::acos(-1.0) / 180.0;
  const Eigen::Vector3d light(std::sin(turn), 0, std::cos(turn));
  EXPECT_NEAR(surface.reflected({0.5, 0.0}, normal, light, viewer), 0.5 * std::cos(turn), 1e-12);
  // The half vector is 10 degrees off: the highlight has fallen to 1/e.
  EXPECT_NEAR(surface.reflected({0.5, 1.0}, normal, light, viewer),
              0.5 * std::cos(turn) + 3.0 / std::exp(1.0), 1e-12);
  EXPECT_EQ(surface.reflected({0.5, 1.0}, normal, -light, viewer), 0.0);
}

TEST(Reflectance, NamesAFieldOutOfItsRange) {
  Reflectance reflectance;
  reflectance.dark_albedo = 0.0;
  EXPECT_THAT(validate(reflectance), HasError("dark_albedo"));
}

}  // namespace
}  // namespace relief::simulation
