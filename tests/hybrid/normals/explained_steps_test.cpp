#include "hybrid/normals/explained_steps.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

constexpr int kSide = 120;
const Camera kCamera = Camera::pinhole(kSide, kSide, {400.0, 400.0, 59.5, 59.5});

// A ball of radius 50 before a wall.
RangeView ball_before_a_wall() {
  const auto ball = testing::sphere({0, 0, 400}, 50.0),
             wall = testing::plane({0, 0, 600}, {0, 0, -1});
  const testing::Surface both = [=](const Ray& ray) { return ball(ray) ? ball(ray) : wall(ray); };
  return testing::render(both, kCamera);
}

bool on_ball(const RangeView& view, int u, int v) { return view.range(u, v) < 500.0; }

std::size_t count(const GridEdges& edges) {
  const auto ones = [](const Grid<std::uint8_t>& grid) {
    return static_cast<std::size_t>(std::count(grid.begin(), grid.end(), std::uint8_t{1}));
  };
  return ones(edges.right) + ones(edges.down);
}

// Every edge that is there afterwards comes from the normals.
GridEdges no_edges() {
  const Grid<std::uint8_t> none(kSide, kSide, 0);
  return {none, none};
}

TEST(ExplainedSteps, ConnectASurfaceUpToItsRimButNotToTheOneBehind) {
  const RangeView view = ball_before_a_wall();
  GridEdges edges = no_edges();
  connect_explained_steps(view, 0.1, edges);
  std::size_t joined = 0, possible = 0;
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u + 1 < kSide; ++u) {
      const bool same = on_ball(view, u, v) == on_ball(view, u + 1, v);
      if (!same) {
        EXPECT_FALSE(edges.connected(u, v, 1, 0)) << u << " " << v;
        continue;
      }
      ++possible;
      joined += edges.connected(u, v, 1, 0) ? 1 : 0;
    }
  }
  EXPECT_GT(static_cast<double>(joined), 0.99 * static_cast<double>(possible));
}

TEST(ExplainedSteps, NeedNormalsThatExplain) {
  RangeView view = ball_before_a_wall();
  for (auto& normal : view.normals) normal = Eigen::Vector3f(0.8f, 0.0f, -0.6f);
  GridEdges edges = no_edges();
  connect_explained_steps(view, 0.01, edges);
  EXPECT_LT(count(edges), 2u * kSide * kSide / 2);  // Along v the plane asks for no step.
  view.normals = {};
  edges = no_edges();
  connect_explained_steps(view, 0.01, edges);
  EXPECT_EQ(count(edges), 0u);
}

TEST(ExplainedSteps, KeepOtherEdges) {
  const RangeView view = ball_before_a_wall();
  const GridEdges before = connect_samples(view);
  GridEdges edges = before;
  connect_explained_steps(view, 0.1, edges);
  EXPECT_GE(count(edges), count(before));
  for (std::size_t i = 0; i < before.right.size(); ++i) {
    EXPECT_GE(edges.right[i], before.right[i]);
    EXPECT_GE(edges.down[i], before.down[i]);
  }
}

}  // namespace
}  // namespace relief::hybrid
