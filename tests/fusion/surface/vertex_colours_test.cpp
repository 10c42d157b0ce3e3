// Colours of views on the merged mesh.

#include "fusion/surface/vertex_colours.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "relief/fusion/merge_views.h"
#include "scan/base/system/system_memory.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace relief::fusion {
namespace {

using Painter = std::function<Colour(const Eigen::Vector3d&)>;

// By the place of each sample in the world.
void paint(RangeView& view, const Painter& painter) {
  view.colours = Grid<Colour>(view.width(), view.height());
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v))
        view.colours(u, v) = painter(view.world_from_view * view.point(u, v));
}

Painter plain(Colour colour) {
  return [=](const Eigen::Vector3d&) { return colour; };
}

// Red along x, green along y, blue along z.
Colour by_place(const Eigen::Vector3d& p) {
  const auto channel = [](double x) { return static_cast<std::uint8_t>(128.0 + 2.0 * x); };
  return {channel(p.x()), channel(p.y()), channel(p.z())};
}

std::vector<RangeView> sphere(int count) {
  return testing::views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), count, 60, 50.0);
}

TriangleMesh merged(const std::vector<RangeView>& views, const Context& context = {}) {
  return value_of(merge_views(views, {}, context)).mesh;
}

int largest_difference(const Colour& a, const Colour& b) {
  int largest = 0;
  for (std::size_t k = 0; k < 3; ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

TEST(VertexColours, ViewsWithoutColoursGiveNone) { EXPECT_TRUE(merged(sphere(8)).colours.empty()); }

TEST(VertexColours, AreThoseOfTheSurface) {
  auto views = sphere(12);
  for (RangeView& view : views) paint(view, by_place);
  const TriangleMesh mesh = merged(views);
  ASSERT_EQ(mesh.colours.size(), mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (mesh.filled[v]) continue;
    EXPECT_LE(largest_difference(mesh.colours[v], by_place(mesh.vertices[v])), 4);
  }
}

// Two views from one place, of one weight.
TEST(VertexColours, OfSeveralViewsAreTheirMean) {
  auto views = sphere(6);
  views.resize(1);
  views.push_back(views[0]);
  paint(views[0], plain({200, 10, 0}));
  paint(views[1], plain({100, 20, 255}));
  const TriangleMesh mesh = merged(views);
  ASSERT_FALSE(mesh.colours.empty());
  for (const Colour& colour : mesh.colours)
    EXPECT_LE(largest_difference(colour, {150, 15, 128}), 1) << "filled ones as well";
}

TEST(VertexColours, WhereNoViewHasThemTheyGoOnSmoothly) {
  auto views = sphere(12);
  views.resize(9);
  for (std::size_t i = 0; i < views.size(); i += 2) paint(views[i], by_place);
  const TriangleMesh mesh = merged(views);
  ASSERT_EQ(mesh.colours.size(), mesh.vertices.size());
  int jump = 0, spread = 0;
  for (const auto& face : mesh.faces) {
    const int step = largest_difference(mesh.colours[face[0]], mesh.colours[face[1]]);
    jump = std::max(jump, step);
    if (mesh.filled[face[0]]) spread = std::max(spread, static_cast<int>(mesh.colours[face[0]][0]));
  }
  EXPECT_LT(jump, 25);
  EXPECT_GT(spread, 30) << "nothing is black";
}

TEST(VertexColours, ThreadsOrderAndMemoryDoNotChangeAByte) {
  auto views = sphere(6);
  for (std::size_t i = 0; i < views.size(); ++i)
    paint(views[i], [&](const Eigen::Vector3d& p) {
      Colour colour = by_place(p);
      colour[0] = static_cast<std::uint8_t>(colour[0] ^ (i * 7));
      return colour;
    });
  views.push_back(views[2]);  // in all but its colours
  paint(views.back(), plain({1, 2, 3}));
  const auto reference = merged(views, {.threads = 4}).colours;
  if (testing::looks_for_races()) return;
  EXPECT_EQ(merged(views, {.threads = 1}).colours, reference);
  std::reverse(views.begin(), views.end());
  Context context{.threads = 2};
  EXPECT_EQ(merged(views, context).colours, reference);
  const testing::TemporaryFolder folder;
  context.memory = resident_memory() + (std::size_t{2} << 30);
  context.temporary_folder = folder.path();
  EXPECT_EQ(merged(views, context).colours, reference);
}

}  // namespace
}  // namespace relief::fusion
