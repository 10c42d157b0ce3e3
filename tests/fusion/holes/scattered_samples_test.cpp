// What single samples tell of a filled surface.

#include "fusion/holes/scattered_samples.h"

#include <algorithm>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::fusion {
namespace {

constexpr double kReach = 3.0;

// A view from above, one pixel to the unit, of a plane at a height: a third of its columns hang
// together, and of the others it keeps single samples.
RangeView view_of_plane(double height) {
  const Camera camera = Camera::orthographic(30, 30, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  RangeView view = render(testing::plane({0, 0, height}, Eigen::Vector3d::UnitZ()), camera,
                          testing::look_at({0, 0, 50}, {0, 0, 0}, Eigen::Vector3d::UnitY()));
  for (int v = 0; v < view.height(); ++v)
    for (int u = 10; u < view.width(); ++u)
      if (u % 4 != 0 || v % 4 != 0) view.range(u, v) = kNoSample;
  return view;
}

ViewSampler sampler_of(const RangeView& view) { return value_of(ViewSampler::create(view, {})); }

// A filled sheet in the plane z = 0 that the views look at, facing up.
TriangleMesh sheet() {
  TriangleMesh mesh;
  constexpr std::uint32_t kSide = 61;
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x) mesh.vertices.emplace_back(x - 30.0, y - 30.0, 0.0);
  for (std::uint32_t y = 0; y + 1 < kSide; ++y)
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t at = y * kSide + x;
      mesh.faces.push_back({at, at + 1, at + kSide});
      mesh.faces.push_back({at + 1, at + kSide + 1, at + kSide});
    }
  mesh.normals.assign(mesh.vertices.size(), Eigen::Vector3f::UnitZ());
  mesh.filled.assign(mesh.vertices.size(), 1);
  return mesh;
}

auto samples_at(const TriangleMesh& mesh, const std::vector<ViewSampler>& views) {
  return scattered_samples_at(mesh, std::vector<std::uint8_t>(mesh.vertices.size(), 1), views,
                              kReach);
}

std::vector<ViewSampler> samplers_of(const std::vector<RangeView>& views) {
  std::vector<ViewSampler> samplers;
  for (const RangeView& view : views) samplers.push_back(sampler_of(view));
  return samplers;
}

std::size_t scattered_in(const RangeView& view) {
  std::size_t count = 0;
  sampler_of(view).for_scattered_samples([&](const Eigen::Vector3d&) { ++count; });
  return count;
}

TEST(ScatteredSamples, AreThoseOfNoQuad) {
  RangeView view = view_of_plane(1.0);
  EXPECT_EQ(scattered_in(view), 5u * 8u) << "columns 12 to 28, rows 0 to 28";
  view.confidence = Grid<float>(view.width(), view.height(), 1.0f);
  view.confidence(12, 0) = 0.0f;
  EXPECT_EQ(scattered_in(view), 5u * 8u - 1u);
}

TEST(ScatteredSamples, TellHowFarTheyAreFromTheSurface) {
  const TriangleMesh mesh = sheet();
  for (const double height : {1.5, -1.0}) {
    const auto found = samples_at(mesh, samplers_of({view_of_plane(height)}));
    EXPECT_EQ(found.size(), 5u * 8u);
    const double inside = 1.0 - height * height / (kReach * kReach);
    for (const auto& [vertex, at] : found) {
      EXPECT_NEAR(at.offset, height, 1e-5);
      EXPECT_NEAR(at.weight, inside * inside, 1e-5);
    }
  }
  EXPECT_TRUE(samples_at(mesh, samplers_of({view_of_plane(3.5)})).empty()) << "out of reach";
}

TEST(ScatteredSamples, TellNothingOfMeasuredVerticesAndOfTheOtherSide) {
  TriangleMesh mesh = sheet();
  const auto views = samplers_of({view_of_plane(1.0)});
  mesh.normals.assign(mesh.vertices.size(), -Eigen::Vector3f::UnitZ());
  EXPECT_TRUE(samples_at(mesh, views).empty()) << "the view looks at the back";
  mesh = sheet();
  mesh.filled.assign(mesh.vertices.size(), 0);
  EXPECT_TRUE(samples_at(mesh, views).empty());
}

TEST(ScatteredSamples, TakeTheMeanOfViewsInAnyOrder) {
  const TriangleMesh mesh = sheet();
  std::vector<RangeView> views{view_of_plane(0.5), view_of_plane(-0.7), view_of_plane(1.1)};
  const auto found = samples_at(mesh, samplers_of(views));
  std::reverse(views.begin(), views.end());
  const auto reversed = samples_at(mesh, samplers_of(views));
  ASSERT_EQ(found.size(), 5u * 8u);
  ASSERT_EQ(found.size(), reversed.size());
  for (const auto& [vertex, at] : found) {
    EXPECT_EQ(at.offset, reversed.at(vertex).offset);
    EXPECT_EQ(at.weight, reversed.at(vertex).weight);
    EXPECT_GT(at.offset, -0.7);
    EXPECT_LT(at.offset, 1.1);
    EXPECT_GT(at.weight, 2.0);
  }
}

}  // namespace
}  // namespace relief::fusion
