#include "relief/scan/discontinuities.h"

#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "scan/grid/connected_grid.h"
#include "tests/support/parameter_names.h"
#include "tests/support/scenes/synthetic_views.h"

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

class DiscontinuitiesOfAStep : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Heights, DiscontinuitiesOfAStep,
                         ::testing::Values(3.0, 10.0, 1000.0, -5.0), testing::PrintedName());

TEST_P(DiscontinuitiesOfAStep, AStepIsCutExactlyWhereItIs) {
  RangeView view = step_view(GetParam());
  testing::add_range_noise(view, 0.2, 7);
  const GridEdges edges = connect_samples(view);
  for (int v = 0; v < 30; ++v) EXPECT_FALSE(edges.right(19, v));
  EXPECT_EQ(broken(edges.right, 39, 30), 30u);
  EXPECT_EQ(broken(edges.down, 40, 29), 0u);
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

// Part of the samples of the middle of a view that are two pixels or more off a boundary.
double inner_part(const RangeView& view) {
  const Grid<std::uint8_t> distance = boundary_distance(view, connect_samples(view));
  const int width = view.width(), height = view.height();
  double inner = 0.0, count = 0.0;
  for (int v = height / 8; v < height - height / 8; ++v) {
    for (int u = width / 8; u < width - width / 8; ++u) {
      inner += distance(u, v) >= 2 ? 1.0 : 0.0;
      count += 1.0;
    }
  }
  return inner / count;
}

const Camera kPinhole = Camera::pinhole(160, 160, {400.0, 400.0, 79.5, 79.5});

RangeView tilted_plane(double noise) {
  RangeView view = testing::render(testing::plane({0, 0, 400}, {0.6, 0.3, 1}), kPinhole);
  testing::add_range_noise(view, noise, 5);
  return view;
}

TEST(Discontinuities, RoundedRangesAreOneSurface) {
  for (const double step : {0.5, 2.0, 4.0, 10.0}) {
    for (const double noise : {0.01, 0.3}) {
      RangeView view = tilted_plane(noise);
      for (double& t : view.range) t = step * std::round(t / step);
      EXPECT_GT(inner_part(view), 0.98) << step << " " << noise;
    }
  }
}

TEST(Discontinuities, RangesOfRoundedInverseAreOneSurface) {
  for (const double at_400 : {2.0, 4.0, 10.0}) {
    RangeView view = tilted_plane(0.3);
    const double step = at_400 / (400.0 * 400.0);
    for (double& t : view.range) t = 1.0 / (step * std::round(1.0 / (t * step)));
    EXPECT_GT(inner_part(view), 0.98) << at_400;
  }
}

TEST(Discontinuities, SteepSlopesOfRoundedRangesAreOneSurface) {
  RangeView view = testing::render(testing::plane({0, 0, 400}, {3.0, 0.3, 1}), kPinhole);
  testing::add_range_noise(view, 0.3, 5);
  for (double& t : view.range) t = 2.5 * std::round(t / 2.5);
  EXPECT_GT(inner_part(view), 0.9);
}

TEST(Discontinuities, RoundedRangesAreCutAtOcclusionEdges) {
  for (const double step : {2.0, 4.0}) {
    RangeView view = tilted_plane(0.1);
    for (int v = 0; v < 160; ++v)
      for (int u = 80; u < 160; ++u) view.range(u, v) += 4.0 * step;
    for (double& t : view.range) t = step * std::round(t / step);
    const GridEdges edges = connect_samples(view);
    int cut = 0;
    for (int v = 0; v < 160; ++v) cut += edges.connected(79, v, 1, 0) ? 0 : 1;
    EXPECT_GE(cut, 155) << step;
  }
}

TEST(Discontinuities, NoiseOfSeveralSpacingsIsOneSurface) {
  for (const double noise : {1.0, 2.0, 4.0})
    EXPECT_GT(inner_part(tilted_plane(noise)), 0.95) << noise;
}

TEST(Discontinuities, NoiseMayChangeOverTheView) {
  RangeView view = tilted_plane(0.3);
  const RangeView loud = tilted_plane(2.5);
  for (int v = 0; v < 160; ++v)
    for (int u = 0; u < 80; ++u) view.range(u, v) = loud.range(u, v);
  EXPECT_GT(inner_part(view), 0.93);
  for (int v = 0; v < 160; ++v)
    for (int u = 120; u < 160; ++u) view.range(u, v) += 5.0;
  const GridEdges edges = connect_samples(view);
  int cut = 0;
  for (int v = 0; v < 160; ++v) cut += edges.connected(119, v, 1, 0) ? 0 : 1;
  EXPECT_GE(cut, 150);
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
