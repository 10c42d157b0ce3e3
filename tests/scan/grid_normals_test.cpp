#include "scan/grid_normals.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/synthetic_views.h"

namespace relief {
namespace {

const Camera kCamera = Camera::pinhole(80, 60, {100, 100, 39.5, 29.5});

double largest_angle_deg(const Grid<Eigen::Vector3f>& a, const Grid<Eigen::Vector3f>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!a[i].allFinite() || !b[i].allFinite()) continue;
    const double sine = a[i].cross(b[i]).norm(), cosine = a[i].dot(b[i]);
    largest = std::max(largest, std::atan2(sine, cosine) * 57.29577951308232);
  }
  return largest;
}

TEST(GridNormals, AreExactOnAPlane) {
  const RangeView view = testing::render(testing::plane({0, 0, 10}, {0.4, -0.3, -1}), kCamera);
  const GridEdges edges = connect_samples(view);
  EXPECT_LT(largest_angle_deg(estimate_normals(view, edges), view.normals), 1e-3);
  EXPECT_LT(largest_angle_deg(finite_difference_normals(view, edges), view.normals), 1e-3);
}

TEST(GridNormals, FaceTheSensorInEveryCameraConvention) {
  const Camera gl = Camera::pinhole_gl(80, 60, {100, 100, 39.5, 29.5});
  const RangeView view = testing::render(testing::sphere({0, 0, -10}, 3.0), gl);
  const auto normals = estimate_normals(view, connect_samples(view), {.radius = 1});
  EXPECT_GT(normals(40, 30).z(), 0.99f);
  EXPECT_LT(normals(40, 30).cast<double>().dot(gl.ray(40, 30).direction), 0.0);
}

TEST(GridNormals, NeverReachAcrossAnOcclusionEdge) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  for (int v = 0; v < 60; ++v)
    for (int u = 40; u < 80; ++u) view.range(u, v) = 14.0;
  const GridEdges edges = connect_samples(view);
  EXPECT_LT(largest_angle_deg(estimate_normals(view, edges, {.radius = 3}), view.normals), 1e-3);
  EXPECT_LT(largest_angle_deg(finite_difference_normals(view, edges), view.normals), 1e-3);
}

TEST(GridNormals, DoNotDependOnTheThreadCount) {
  RangeView view = testing::render(testing::sphere({0, 0, 10}, 4.0), kCamera);
  testing::add_range_noise(view, 0.01, 5);
  const GridEdges edges = connect_samples(view);
  const auto one = estimate_normals(view, edges, {.radius = 2, .threads = 1});
  const auto four = estimate_normals(view, edges, {.radius = 2, .threads = 4});
  for (std::size_t i = 0; i < one.size(); ++i)
    EXPECT_TRUE(one[i] == four[i] || !one[i].allFinite());
}

TEST(GridNormals, AStrideGivesTheSameNormalsAtFewerPixels) {
  const RangeView view = testing::render(testing::sphere({0, 0, 10}, 4.0), kCamera);
  const GridEdges edges = connect_samples(view);
  const auto all = estimate_normals(view, edges),
             some = estimate_normals(view, edges, {.stride = 3});
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      const bool chosen = u % 3 == 0 && v % 3 == 0 && all(u, v).allFinite();
      EXPECT_EQ(some(u, v).allFinite(), chosen);
      if (chosen) {
        EXPECT_EQ(some(u, v), all(u, v));
      }
    }
  }
}

TEST(GridNormals, AnIsolatedSampleHasNone) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  std::fill(view.range.begin(), view.range.end(), kNoSample);
  view.range(7, 7) = 10.0;
  view.range(20, 7) = view.range(21, 7) = view.range(22, 7) = 10.0;  // and a line of samples
  const GridEdges edges = connect_samples(view);
  for (const auto& normal : estimate_normals(view, edges)) EXPECT_FALSE(normal.allFinite());
  for (const auto& normal : finite_difference_normals(view, edges))
    EXPECT_FALSE(normal.allFinite());
}

}  // namespace
}  // namespace relief
