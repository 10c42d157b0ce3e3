#include "scan/grid/grid_normals.h"

#include <cmath>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "scan/base/linear_algebra.h"
#include "tests/support/scenes/synthetic_views.h"

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

// The direction of least scatter of the samples in a window, none of which is across an edge.
Eigen::Vector3d brute_force_normal(const RangeView& view, int u, int v, int radius) {
  std::vector<Eigen::Vector3d> points;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int y = v - radius; y <= v + radius; ++y)
    for (int x = u - radius; x <= u + radius; ++x)
      if (view.has_sample(x, y)) points.push_back(view.point(x, y));
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& p : points) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::Vector3d normal = eigen_decomposition(scatter).eigenvectors().col(0);
  return normal.dot(view.camera.ray(u, v).direction) > 0.0 ? Eigen::Vector3d(-normal) : normal;
}

// Windows inside the surface are summed along rows, those at its boundary sample by sample.
TEST(GridNormals, AreThoseOfThePlaneThroughTheWindowFarFromTheOriginToo) {
  for (const double offset : {0.0, 1e5}) {
    const Camera camera =
        Camera::orthographic(60, 50, {offset, -offset, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 1});
    RangeView view =
        testing::render(testing::sphere({offset + 3.0, -offset + 2.5, 10.0}, 2.0), camera);
    testing::add_range_noise(view, 0.02, 7);
    const GridEdges edges = connect_samples(view);
    const auto boundary = boundary_distance(view, edges);
    const auto normals = estimate_normals(view, edges, {.radius = 3});
    int inside = 0;
    for (int v = 0; v < 50; ++v) {
      for (int u = 0; u < 60; ++u) {
        if (boundary(u, v) <= 3) continue;
        const Eigen::Vector3d expected = brute_force_normal(view, u, v, 3);
        EXPECT_LT((normals(u, v).cast<double>() - expected).norm(), 1e-5) << u << ' ' << v;
        ++inside;
      }
    }
    EXPECT_GT(inside, 300);
  }
}

TEST(GridNormals, DoNotDependOnTheThreadCount) {
  RangeView view = testing::render(testing::sphere({0, 0, 10}, 4.0), kCamera);
  testing::add_range_noise(view, 0.01, 5);
  const GridEdges edges = connect_samples(view);
  const auto estimated_on = [&](int threads) {
    return on_threads(threads, [&] { return estimate_normals(view, edges, {.radius = 2}); });
  };
  const auto one = estimated_on(1), four = estimated_on(4);
  for (std::size_t i = 0; i < one.size(); ++i)
    EXPECT_TRUE(one[i] == four[i] || !one[i].allFinite());
}

TEST(GridNormals, AStrideAndAMarginGiveTheSameNormalsAtFewerPixels) {
  const RangeView view = testing::render(testing::sphere({0, 0, 10}, 2.0), kCamera);
  const ConnectedGrid grid = connect_grid(view);
  const auto all = estimate_normals(view, grid);
  for (const GridNormalOptions& options :
       {GridNormalOptions{.stride = 3}, GridNormalOptions{.margin = 2}}) {
    const auto some = estimate_normals(view, grid, options);
    for (int v = 0; v < view.height(); ++v) {
      for (int u = 0; u < view.width(); ++u) {
        const bool chosen = u % options.stride == 0 && v % options.stride == 0 &&
                            grid.boundary(u, v) >= options.margin && all(u, v).allFinite();
        EXPECT_EQ(some(u, v).allFinite(), chosen);
        if (chosen) {
          EXPECT_LT((some(u, v) - all(u, v)).norm(), 1e-6f);
        }
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

// As of a wall beside a lidar: its noise is larger than a window. Across the plane, most normals
// turn into the surface, to the same side at the same pixel of all views.
TEST(GridNormals, NoiseLargerThanAWindowTurnsThemNowhere) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0.5, 0, -1}), kCamera);
  const auto truth = view.normals;
  testing::add_range_noise(view, 0.3, 1);  // Windows have a standard deviation of 0.14.
  const GridEdges edges = connect_samples(view);
  const RangeNoise noise = estimate_range_noise(view);
  ASSERT_NEAR(noise.sigma, 0.3, 0.1);
  const auto mean_angle_deg = [&](const Grid<Eigen::Vector3f>& normals) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3f& normal : normals)
      if (normal.allFinite()) sum += normal.cast<double>();
    return std::acos(sum.normalized().dot(truth(40, 30).cast<double>())) * 57.29577951308232;
  };
  EXPECT_GT(mean_angle_deg(estimate_normals(view, edges)), 10.0);
  EXPECT_LT(mean_angle_deg(estimate_normals(view, edges, {.noise = &noise})), 4.0);
}

}  // namespace
}  // namespace relief
