// Styles that show attributes of vertices.
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/rendering/render_mesh.h"
#include "tests/scan/rendering/shapes.h"
#include "tests/support/result_matchers.h"

namespace relief::rendering {
namespace {

using testing::from_above;
using testing::plate;

// A plate of 10 x 10 faces; `left` where x < 0, else `right`.
constexpr int kSide = 10;

template <typename Value>
PagedVector<Value> halves(const TriangleMesh& mesh, Value left, Value right) {
  PagedVector<Value> values;
  for (const auto& vertex : mesh.vertices) values.push_back(vertex.x() < 0.0 ? left : right);
  return values;
}

struct Sides {
  Rgba left, right;
  std::optional<Legend> legend;
};

Sides rendered(const TriangleMesh& mesh, RenderStyle style, const RenderOptions& options = {}) {
  const auto rendering = value_of(render_mesh(mesh, from_above(9, 9, 1.0), style, options));
  return {rendering.picture(0, 4), rendering.picture(8, 4), rendering.legend};
}

Colour colour_of(const Rgba& pixel) { return {pixel[0], pixel[1], pixel[2]}; }

TEST(Styles, ExpectedErrorsGoFromZeroToMostOfThem) {
  TriangleMesh mesh = plate(5.0, kSide);
  mesh.quality = halves(mesh, 0.0f, 0.25f);
  const Sides sides = rendered(mesh, RenderStyle::kExpectedError, {.unit = "mm"});
  ASSERT_TRUE(sides.legend);
  EXPECT_EQ(sides.legend->title, "expected error [mm]");
  EXPECT_EQ(sides.legend->low, 0.0);
  EXPECT_NEAR(sides.legend->high, 0.25, 1e-9);
  // The plate faces the viewer, so colours have full light.
  EXPECT_EQ(colour_of(sides.left), sides.legend->bar.front());
  EXPECT_EQ(colour_of(sides.right), sides.legend->bar.back());
}

TEST(Styles, FilledVerticesHaveNoExpectedError) {
  TriangleMesh mesh = plate(5.0, kSide);
  mesh.quality = halves(mesh, 0.25f, 90.0f);
  mesh.filled = halves(mesh, std::uint8_t{0}, std::uint8_t{1});
  const Sides sides = rendered(mesh, RenderStyle::kExpectedError);
  ASSERT_TRUE(sides.legend);
  EXPECT_NEAR(sides.legend->high, 0.25, 1e-9);
  ASSERT_EQ(sides.legend->entries.size(), 1u);
  EXPECT_EQ(colour_of(sides.right), sides.legend->entries[0].colour);
  EXPECT_EQ(colour_of(sides.left), sides.legend->bar.back());
}

TEST(Styles, FilledAndMeasuredHaveTheColoursOfTheLegend) {
  TriangleMesh mesh = plate(5.0, kSide);
  mesh.filled = halves(mesh, std::uint8_t{0}, std::uint8_t{1});
  const Sides sides = rendered(mesh, RenderStyle::kFilled);
  ASSERT_TRUE(sides.legend && sides.legend->entries.size() == 2);
  EXPECT_EQ(colour_of(sides.left), sides.legend->entries[0].colour);
  EXPECT_EQ(colour_of(sides.right), sides.legend->entries[1].colour);
}

TEST(Styles, ViewsGoFromZeroToTheMost) {
  TriangleMesh mesh = plate(5.0, kSide);
  mesh.views = halves(mesh, std::uint16_t{0}, std::uint16_t{7});
  const Sides sides = rendered(mesh, RenderStyle::kViews);
  ASSERT_TRUE(sides.legend);
  EXPECT_EQ(sides.legend->high, 7.0);
  EXPECT_EQ(colour_of(sides.left), sides.legend->bar.front());
  EXPECT_EQ(colour_of(sides.right), sides.legend->bar.back());
}

TEST(Styles, DistancesHaveASign) {
  const TriangleMesh mesh = plate(5.0, kSide);
  const auto distances = halves(mesh, -0.5, 0.5);
  const Sides sides =
      rendered(mesh, RenderStyle::kDistance, {.distances = {distances.begin(), distances.end()}});
  ASSERT_TRUE(sides.legend);
  EXPECT_EQ(sides.legend->low, -0.5);
  EXPECT_EQ(sides.legend->high, 0.5);
  EXPECT_GT(sides.left[2], sides.left[0] + 50);    // blue
  EXPECT_GT(sides.right[0], sides.right[2] + 50);  // red
}

TEST(Styles, TheRangeThatIsGivenHolds) {
  TriangleMesh mesh = plate(5.0, kSide);
  mesh.quality = halves(mesh, 1.0f, 3.0f);
  const Sides sides = rendered(mesh, RenderStyle::kExpectedError, {.range = std::array{1.0, 2.0}});
  ASSERT_TRUE(sides.legend);
  EXPECT_EQ(sides.legend->low, 1.0);
  EXPECT_EQ(colour_of(sides.left), sides.legend->bar.front());
  EXPECT_EQ(colour_of(sides.right), sides.legend->bar.back());
}

TEST(Styles, ColoursAreThoseOfTheVertices) {
  TriangleMesh mesh = plate(5.0, kSide);
  mesh.colours = halves(mesh, Colour{10, 200, 30}, Colour{255, 0, 128});
  const Sides sides = rendered(mesh, RenderStyle::kColours);
  EXPECT_EQ(colour_of(sides.left), (Colour{10, 200, 30}));
  EXPECT_EQ(colour_of(sides.right), (Colour{255, 0, 128}));
  EXPECT_FALSE(sides.legend);
}

TEST(Styles, MissingAttributesAreNamedWithWhatToDo) {
  const TriangleMesh mesh = plate(5.0);
  const auto render = [&](RenderStyle style) {
    return render_mesh(mesh, from_above(3, 3, 1.0), style);
  };
  EXPECT_THAT(render(RenderStyle::kExpectedError), HasError("expected error (quality)"));
  EXPECT_THAT(render(RenderStyle::kFilled), HasError("relief merge"));
  EXPECT_THAT(render(RenderStyle::kViews), HasError("how many views"));
  EXPECT_THAT(render(RenderStyle::kDistance), HasError("--truth"));
  EXPECT_THAT(render(RenderStyle::kColours), HasError("choose another style"));
}

TEST(SurfaceOfView, HasTheDeviationsOfItsSamples) {
  RangeView view;
  view.camera = Camera::pinhole(4, 3, {10, 10, 1.5, 1});
  view.range = Grid<double>(4, 3, 5.0);
  view.range(1, 0) = kNoSample;
  view.deviation = Grid<float>(4, 3, 0.0f);
  for (std::size_t i = 0; i < view.deviation.size(); ++i) view.deviation[i] = static_cast<float>(i);
  const TriangleMesh mesh = surface_of_view(view);
  ASSERT_EQ(mesh.quality.size(), mesh.vertices.size());
  ASSERT_EQ(mesh.quality.size(), 11u);
  EXPECT_EQ(mesh.quality[0], 0.0f);
  EXPECT_EQ(mesh.quality[1], 2.0f);
  EXPECT_EQ(mesh.quality[10], 11.0f);
}

}  // namespace
}  // namespace relief::rendering
