#include "scan/discontinuities.h"

#include <gtest/gtest.h>

#include "tests/support/synthetic_views.h"

namespace relief {
namespace {

const Camera kCamera = Camera::orthographic(40, 30, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});

RangeView step_view(double step) {
  RangeView view = testing::render(testing::plane({0, 0, 100}, {0, 0, 1}), kCamera);
  for (int v = 0; v < 30; ++v)
    for (int u = 20; u < 40; ++u) view.range(u, v) += step;
  return view;
}

std::size_t broken(const Grid<std::uint8_t>& edges, int width, int height) {
  std::size_t count = 0;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) count += edges(u, v) == 0;
  return count;
}

TEST(Discontinuities, AStepIsCutExactlyWhereItIs) {
  for (const double step : {3.0, 10.0, 1000.0, -5.0}) {
    RangeView view = step_view(step);
    testing::add_range_noise(view, 0.2, 7);
    const GridEdges edges = connect_samples(view);
    for (int v = 0; v < 30; ++v) EXPECT_FALSE(edges.right(19, v)) << step;
    EXPECT_EQ(broken(edges.right, 39, 30), 30u) << step;
    EXPECT_EQ(broken(edges.down, 40, 29), 0u) << step;
  }
}

TEST(Discontinuities, ASteepPlaneIsOneSurface) {
  const RangeView view = testing::render(testing::plane({0, 0, 100}, {4, 0, 1}), kCamera);
  EXPECT_EQ(broken(connect_samples(view).right, 39, 30), 0u);
}

TEST(Discontinuities, NoSurfaceIsSeenAtAlmostGrazingAngles) {
  const RangeView view = testing::render(testing::plane({0, 0, 100}, {12, 0, 1}), kCamera);
  EXPECT_EQ(broken(connect_samples(view).right, 39, 30), 39u * 30u);
}

TEST(Discontinuities, NothingDependsOnTheUnit) {
  RangeView small = step_view(3.0);
  testing::add_range_noise(small, 0.3, 3);
  RangeView large = small;
  large.camera = Camera::orthographic(40, 30, {0, 0, 0}, {1000, 0, 0}, {0, 1000, 0}, {0, 0, 1});
  for (double& t : large.range) t *= 1000.0;
  const GridEdges a = connect_samples(small), b = connect_samples(large);
  EXPECT_TRUE(std::equal(a.right.begin(), a.right.end(), b.right.begin()));
  EXPECT_TRUE(std::equal(a.down.begin(), a.down.end(), b.down.begin()));
}

TEST(Discontinuities, MissingSamplesConnectToNothing) {
  RangeView view = step_view(0.0);
  view.range(5, 5) = kNoSample;
  const GridEdges edges = connect_samples(view);
  EXPECT_FALSE(edges.connected(5, 5, 1, 0));
  EXPECT_FALSE(edges.connected(4, 5, 1, 0));
  EXPECT_FALSE(edges.connected(5, 6, 0, -1));
  EXPECT_TRUE(edges.connected(6, 5, 1, 0));
  EXPECT_FALSE(edges.connected(39, 5, 1, 0));
}

TEST(BoundaryDistance, CountsPixelsToTheNearestBoundary) {
  RangeView view = step_view(0.0);
  view.range(20, 15) = kNoSample;
  const Grid<std::uint8_t> distance = boundary_distance(view, connect_samples(view));
  EXPECT_EQ(distance(0, 10), 0);
  EXPECT_EQ(distance(3, 10), 3);
  EXPECT_EQ(distance(39, 29), 0);
  EXPECT_EQ(distance(20, 15), 0);
  EXPECT_EQ(distance(20, 14), 0);
  EXPECT_EQ(distance(22, 15), 1);
}

}  // namespace
}  // namespace relief
