// The expected error of the vertices of a merged mesh.

#include "fusion/surface/vertex_attributes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "relief/fusion/merge_views.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::fusion {
namespace {

constexpr double kRadius = 50.0;

// Views of a sphere that know their deviations; those of samples with z > 0 are `above` [unit].
std::vector<RangeView> views_with_deviations(double above, double below) {
  auto views =
      testing::views_around(testing::sphere(Eigen::Vector3d::Zero(), kRadius), 16, 100, kRadius);
  for (std::size_t i = 0; i < views.size(); ++i) {
    RangeView& view = views[i];
    view.deviation = Grid<float>(view.width(), view.height(), static_cast<float>(kNoSample));
    RangeView noise = view;
    testing::add_range_noise(noise, 1.0, static_cast<std::uint32_t>(i));
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u) {
        if (!view.has_sample(u, v)) continue;
        const Eigen::Vector3d place = view.world_from_view * view.point(u, v);
        const double sigma = place.z() > 0.0 ? above : below;
        view.deviation(u, v) = static_cast<float>(sigma);
        view.range(u, v) += sigma * (noise.range(u, v) - view.range(u, v));
      }
  }
  return views;
}

struct Errors {
  double real = 0.0, expected = 0.0;  // RMS [unit].
};

// Of the measured vertices on one side of the plane z = 0, away from it.
Errors errors_on(const TriangleMesh& mesh, double side) {
  Errors errors;
  double count = 0.0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (mesh.filled[v] || side * mesh.vertices[v].z() < 10.0) continue;
    errors.real += std::pow(mesh.vertices[v].norm() - kRadius, 2);
    errors.expected += std::pow(mesh.quality[v], 2);
    count += 1.0;
  }
  return {std::sqrt(errors.real / count), std::sqrt(errors.expected / count)};
}

TEST(VertexAttributes, ExpectedErrorsFollowWhatViewsKnowOfTheirSamples) {
  const TriangleMesh mesh = value_of(merge_views(views_with_deviations(0.4, 0.1))).mesh;
  const Errors above = errors_on(mesh, 1.0), below = errors_on(mesh, -1.0);
  RecordProperty("above", std::to_string(above.expected / above.real));
  RecordProperty("below", std::to_string(below.expected / below.real));
  EXPECT_GT(above.real, 2.5 * below.real);
  for (const Errors& side : {above, below}) {
    EXPECT_GT(side.expected, 0.8 * side.real);
    EXPECT_LT(side.expected, 1.6 * side.real);
  }
}

// Views are asked by groups of vertices. Shuffled, each group spans the object.
TEST(VertexAttributes, DoNotDependOnTheOrderOfVertices) {
  const auto views = views_with_deviations(0.4, 0.1);
  TriangleMesh mesh = value_of(merge_views(views)).mesh;
  TriangleMesh shuffled = mesh;
  std::vector<std::uint32_t> place(mesh.vertices.size());
  std::iota(place.begin(), place.end(), 0u);
  std::shuffle(place.begin(), place.end(), std::mt19937(3));
  for (std::size_t v = 0; v < place.size(); ++v) shuffled.vertices[place[v]] = mesh.vertices[v];
  for (auto& face : shuffled.faces)
    for (std::uint32_t& v : face) v = place[v];
  std::vector<ViewSampler> samplers;
  for (const RangeView& view : views) samplers.push_back(value_of(ViewSampler::create(view, {})));
  const VertexAttributeOptions options{.truncation = 4.0, .voxel_size = 1.0, .view_stddev = 0.3};
  set_vertex_attributes(mesh, samplers, options);
  set_vertex_attributes(shuffled, samplers, options);
  for (std::size_t v = 0; v < place.size(); ++v) {
    ASSERT_EQ(mesh.views[v], shuffled.views[place[v]]) << v;
    ASSERT_EQ(mesh.filled[v], shuffled.filled[place[v]]) << v;
    ASSERT_EQ(mesh.quality[v], shuffled.quality[place[v]]) << v;
  }
}

}  // namespace
}  // namespace relief::fusion
