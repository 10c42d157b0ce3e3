#include "scan/surface/range_surface.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scan/surface/observation_weights.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

const Camera kCamera = Camera::pinhole(80, 60, {100, 100, 39.5, 29.5});

RangeSurface surface_of(const RangeView& view) {
  return RangeSurface(view, connect_grid(view), view.normals);
}

TEST(SurfaceQuad, SharesAreBilinearAndEndWithTheGrid) {
  const auto quad = SurfaceQuad::at({3.25, 4.5}, 6, 6);
  ASSERT_TRUE(quad);
  EXPECT_EQ(quad->u, 3);
  EXPECT_EQ(quad->v, 4);
  EXPECT_DOUBLE_EQ(quad->shares[0], 0.375);
  EXPECT_DOUBLE_EQ(quad->shares[1], 0.125);
  EXPECT_DOUBLE_EQ(quad->shares[2], 0.375);
  EXPECT_DOUBLE_EQ(quad->shares[3], 0.125);
  EXPECT_FALSE(SurfaceQuad::at({5.0, 4.5}, 6, 6));
  EXPECT_FALSE(SurfaceQuad::at({-0.1, 4.5}, 6, 6));
  EXPECT_FALSE(SurfaceQuad::at({NAN, 4.5}, 6, 6));
}

// The chord of a circle of radius R is off by h^2 / (8 R) in the middle of samples h apart; what is
// left over after bending is of fourth order.
TEST(RangeSurface, BendsTheChordAsTheSurfaceDoes) {
  const Eigen::Vector3d centre(0, 0, 10);
  const double radius = 1.0, spacing = 0.09, sag = spacing * spacing / (4 * radius);
  const RangeView view = testing::render(testing::sphere(centre, radius), kCamera);
  const RangeSurface surface = surface_of(view);
  for (const auto& pixel : {Eigen::Vector2d(39.5, 29.5), Eigen::Vector2d(36.5, 31.5)}) {
    const auto quad = surface.quad_at(pixel);
    ASSERT_TRUE(quad);
    const auto patch = surface.patch(*quad);
    ASSERT_TRUE(patch);
    const Eigen::Vector3d chord = patch->origin + patch->chord, normal = patch->normal;
    EXPECT_NEAR((chord - centre).norm(), radius - sag, 0.2 * sag);
    EXPECT_NEAR((patch->point() - centre).norm(), radius, 0.05 * sag);
    EXPECT_NEAR(patch->distance(patch->point()), 0.0, 1e-12);
    for (const double distance : {-0.02, 0.03})
      EXPECT_NEAR(patch->distance(patch->point() + distance * normal), distance, 1e-12);
    EXPECT_NEAR((normal - (chord - centre).normalized()).norm(), 0.0, 1e-3);
  }
}

TEST(RangeSurface, HasNoQuadAcrossAnOcclusionEdge) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  for (int v = 0; v < 60; ++v)
    for (int u = 40; u < 80; ++u) view.range(u, v) -= 3.0;
  const RangeSurface surface = surface_of(view);
  EXPECT_TRUE(surface.has_sample(39, 30) && surface.has_sample(40, 30));
  EXPECT_FALSE(surface.has_quad(39, 30));
  EXPECT_FALSE(surface.quad_at({39.5, 30.5}));
  EXPECT_TRUE(surface.quad_at({38.5, 30.5}));
  EXPECT_TRUE(surface.quad_at({40.5, 30.5}));
  EXPECT_FALSE(surface.quad_at({38.5, 30.5}, 1)) << "its right corners lie on the edge";
  EXPECT_TRUE(surface.quad_at({37.5, 30.5}, 1));
  EXPECT_EQ(surface.boundary_distance(36, 30), 3);
}

TEST(RangeSurface, IsOfSamplesWithNormalsAndWeights) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  view.confidence = Grid<float>(80, 60, 0.5f);
  view.confidence(20, 20) = 0.0f;
  view.normals(40, 20).setConstant(static_cast<float>(kNoSample));
  view.range(60, 20) = kNoSample;
  const RangeSurface surface = surface_of(view);
  for (const int u : {20, 40, 60}) {
    EXPECT_FALSE(surface.has_sample(u, 20)) << u;
    for (const int du : {-1, 0}) {
      for (const int dv : {-1, 0}) EXPECT_FALSE(surface.has_quad(u + du, 20 + dv)) << u;
    }
    EXPECT_TRUE(surface.has_quad(u + 1, 20)) << u;
  }
  std::size_t count = 0;
  surface.for_each_sample([&](int u, int v) {
    ASSERT_TRUE(surface.has_sample(u, v));
    ++count;
  });
  EXPECT_EQ(count, 80u * 60u - 3u);
  EXPECT_DOUBLE_EQ(surface.weight(10, 10), 0.5);
  EXPECT_DOUBLE_EQ(surface.patch(*surface.quad_at({10.5, 10.5}))->weight, 0.5);
}

TEST(RangeSurface, TakesWeightsInPlaceOfConfidences) {
  const RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  Grid<float> weights(80, 60, 2.0f);
  weights(11, 10) = 4.0f;
  const RangeSurface surface(view, connect_grid(view), view.normals, weights);
  EXPECT_DOUBLE_EQ(surface.patch(*surface.quad_at({10.5, 10.0}))->weight, 3.0);
}

TEST(ObservationWeights, GrowFromTheBoundaryWithConfidenceAndCosine) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  const ConnectedGrid grid = connect_grid(view);
  const auto weights_of = [&](const ObservationWeightOptions& options) {
    return observation_weights(view, grid, view.normals, options);
  };
  const Grid<float> plain = weights_of({});
  EXPECT_NEAR(plain(39, 29), 1.0, 1e-3);
  const double cosine = -view.camera.ray(10, 29).direction.normalized().z();
  EXPECT_NEAR(plain(10, 29), -cosine, 1e-6);
  for (int u = 1; u < 6; ++u) EXPECT_GT(plain(u, 29), plain(u - 1, 29));
  EXPECT_NEAR(plain(3, 29) / plain(6, 29), 3.1 / 6.1, 0.02);
  view.confidence = Grid<float>(80, 60, 0.5f);
  view.confidence(30, 29) = 0.0f;
  view.deviation = Grid<float>(80, 60, 0.1f);
  view.deviation(20, 29) = static_cast<float>(kNoSample);
  EXPECT_NEAR(weights_of({})(39, 29), 0.5 * plain(39, 29), 1e-6) << "no nominal deviation";
  const Grid<float> known = weights_of({.nominal_deviation = 0.2});
  EXPECT_NEAR(known(39, 29), 4.0 * plain(39, 29), 1e-2);
  EXPECT_NEAR(known(20, 29), 0.5 * plain(20, 29), 1e-6) << "unknown there";
  EXPECT_EQ(known(30, 29), 0.0f);
}

}  // namespace
}  // namespace relief
