#include "hybrid/model/prepared_view.h"

#include <cmath>

#include <gtest/gtest.h>

namespace relief::hybrid {
namespace {

constexpr int kSide = 40;
constexpr double kNear = 80.0, kFar = 100.0;

// A step of 20 spacings between columns 19 and 20.
RangeView two_walls() {
  RangeView view;
  view.camera =
      Camera::orthographic(kSide, kSide, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(),
                           Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ());
  view.range = {kSide, kSide, kFar};
  for (int v = 0; v < kSide; ++v)  // Not so even as to look rounded.
    for (int u = 0; u < kSide; ++u)
      view.range(u, v) = (u < 20 ? kNear : kFar) + 0.1 * std::sin(0.7 * u + 1.3 * v + 0.01 * u * v);
  return view;
}

// One sample is off the farther wall, by most of the way to the nearer one.
PreparedView with_a_flying_sample(int u, int v) {
  RangeView view = two_walls();
  view.range(u, v) = 86.0;
  PreparedView prepared = prepare_view(view, {});
  EXPECT_EQ(prepared.flying, 1u);
  return prepared;
}

TEST(PreparedView, FillsFlyingSamplesInsideASurface) {
  const PreparedView prepared = with_a_flying_sample(30, 20);
  EXPECT_EQ(prepared.filled, 1u);
  EXPECT_NEAR(prepared.view.range(30, 20), kFar, 0.3);
}

// The farther wall would fill the gap.
TEST(PreparedView, LeavesFlyingSamplesAtTheRimOfANearerSurfaceOpen) {
  const PreparedView prepared = with_a_flying_sample(20, 20);
  EXPECT_EQ(prepared.filled, 0u);
  EXPECT_FALSE(prepared.view.has_sample(20, 20));
}

TEST(PreparedView, FillsGapsInsideASurface) {
  RangeView view = two_walls();
  view.range(30, 20) = kNoSample;
  const PreparedView prepared = prepare_view(view, {});
  EXPECT_EQ(prepared.filled, 1u);
  EXPECT_NEAR(prepared.view.range(30, 20), kFar, 0.3);
  EXPECT_TRUE(prepared.edges.connected(30, 20, 1, 0));
}

// The last column of the nearer wall and the first of the farther one.
TEST(PreparedView, LeavesGapsBesideOcclusionEdgesOpen) {
  for (const int u : {19, 20}) {
    RangeView view = two_walls();
    view.range(u, 20) = kNoSample;
    const PreparedView prepared = prepare_view(view, {});
    EXPECT_EQ(prepared.filled, 0u);
    EXPECT_FALSE(prepared.view.has_sample(u, 20));
    for (const int du : {-1, 1}) EXPECT_FALSE(prepared.edges.connected(u, 20, du, 0));
    for (const int dv : {-1, 1}) EXPECT_FALSE(prepared.edges.connected(u, 20, 0, dv));
  }
}

}  // namespace
}  // namespace relief::hybrid
