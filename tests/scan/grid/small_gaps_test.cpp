#include "scan/grid/small_gaps.h"

#include <cmath>

#include <gtest/gtest.h>

#include "relief/scan/range_view.h"

namespace relief {
namespace {

// A slanted, gently curved surface seen by a pinhole camera.
RangeView curved_view(int size) {
  RangeView view;
  view.camera = Camera::pinhole(size, size, {1.2 * size, 1.2 * size, 0.5 * size, 0.5 * size});
  view.range = Grid<double>(size, size);
  for (int v = 0; v < size; ++v)
    for (int u = 0; u < size; ++u)
      view.range(u, v) = 100.0 + 0.3 * u * 100.0 / (1.2 * size) + 1e-3 * (v - 20.0) * (v - 20.0);
  return view;
}

TEST(SmallGaps, RestoresSamplesMissingAtRandom) {
  const RangeView whole = curved_view(96);
  RangeView view = whole;
  std::size_t lost = 0;
  for (std::size_t i = 0; i < view.range.size(); ++i) {
    if ((i * 2654435761u >> 7) % 100 >= 15) continue;
    view.range[i] = kNoSample;
    ++lost;
  }
  const BridgedRange bridged = bridge_small_gaps(view);
  EXPECT_GT(lost, 1000u);
  EXPECT_GT(bridged.bridged_count, 0.97 * static_cast<double>(lost));
  for (std::size_t i = 0; i < view.range.size(); ++i) {
    if (!bridged.bridged[i]) continue;
    EXPECT_TRUE(std::isnan(view.range[i]));
    EXPECT_NEAR(bridged.range[i], whole.range[i], 0.01);
  }
}

// A depth map carried into the image of a camera with finer pixels misses rows and columns.
TEST(SmallGaps, BridgesALatticeOfMissingLines) {
  const RangeView whole = curved_view(64);
  RangeView view = whole;
  const auto missing = [](int k) { return k % 4 == 3 || k % 9 == 0; };  // Up to two side by side.
  for (int v = 0; v < 64; ++v)
    for (int u = 0; u < 64; ++u)
      if (missing(u) || missing(v)) view.range(u, v) = kNoSample;
  const BridgedRange bridged = bridge_small_gaps(view);
  for (int v = 2; v < 62; ++v)
    for (int u = 2; u < 62; ++u)
      EXPECT_NEAR(bridged.range(u, v), whole.range(u, v), 0.01) << u << ' ' << v;
}

TEST(SmallGaps, KeepsMeasuredRangesToTheBit) {
  RangeView view = curved_view(32);
  view.range(10, 10) = kNoSample;
  const BridgedRange bridged = bridge_small_gaps(view);
  EXPECT_EQ(bridged.bridged_count, 1u);
  for (std::size_t i = 0; i < view.range.size(); ++i)
    EXPECT_TRUE(bridged.bridged[i] || bridged.range[i] == view.range[i]);
}

TEST(SmallGaps, DoesNotBridgeOcclusionEdges) {
  RangeView view = curved_view(64);
  for (int v = 0; v < 64; ++v) {
    for (int u = 32; u < 64; ++u) view.range(u, v) += 20.0;
    view.range(31, v) = view.range(32, v) = kNoSample;
  }
  const BridgedRange bridged = bridge_small_gaps(view);
  EXPECT_EQ(bridged.bridged_count, 0u);
}

TEST(SmallGaps, LeavesWideHoles) {
  RangeView view = curved_view(64);
  for (int v = 20; v < 30; ++v)
    for (int u = 20; u < 30; ++u) view.range(u, v) = kNoSample;
  EXPECT_EQ(bridge_small_gaps(view).bridged_count, 0u);
}

TEST(SmallGaps, AllowsForNoise) {
  RangeView view = curved_view(64);
  const double spacing = 100.0 / (1.2 * 64);
  view.range(20, 20) += 5.0 * spacing;  // Two and a half deviations of the noise.
  view.range(21, 20) = kNoSample;
  EXPECT_EQ(bridge_small_gaps(view, {.widest = 1}).range(21, 20),
            0.5 * (view.range(21, 19) + view.range(21, 21)));
  view.range(21, 19) = view.range(21, 21) = kNoSample;
  EXPECT_FALSE(bridge_small_gaps(view, {.widest = 1}).bridged(21, 20));
  EXPECT_TRUE(bridge_small_gaps(view, {.widest = 1, .sigma = 2.0 * spacing}).bridged(21, 20));
}

}  // namespace
}  // namespace relief
