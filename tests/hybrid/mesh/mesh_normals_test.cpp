#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "relief/hybrid/polish_mesh.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/hybrid/mesh_shapes.h"
#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

using testing::kDegree;
using testing::sphere_mesh;

constexpr double kRadius = 30.0;

// Views of a sphere from six sides, 1.0 between samples at its nearest point.
std::vector<RangeView> sphere_views(double noise_deg = 0.0, std::uint32_t seed = 0) {
  std::vector<RangeView> views;
  const Camera camera = Camera::pinhole(96, 96, {170, 170, 47.5, 47.5});
  for (const Eigen::Vector3d& side :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(0, 1, 0),
        Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0.1, 0, 1), Eigen::Vector3d(0.1, 0, -1)}) {
    views.push_back(testing::render(testing::sphere({0, 0, 0}, kRadius), camera,
                                    testing::look_at(200.0 * side.normalized(), {0, 0, 0})));
    views.back().pose = PoseKind::kKnown;
    if (noise_deg > 0.0)
      testing::add_normal_noise(views.back(), noise_deg * kDegree,
                                seed + static_cast<std::uint32_t>(views.size()));
  }
  return views;
}

MeshNormals blended(const TriangleMesh& mesh, const std::vector<RangeView>& views) {
  return value_of(vertex_normals_from_views(mesh, views));
}

// RMS of the angle to the sphere's normals over the vertices that have one [rad].
double sphere_error(const TriangleMesh& mesh, const MeshNormals& normals) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (normals.views[i] == 0) continue;
    sum += (normals.normals[i].cast<double>() - mesh.vertices[i].normalized()).squaredNorm();
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

TEST(MeshNormals, ExactViewsGiveTheNormalsOfASphere) {
  const TriangleMesh mesh = sphere_mesh(kRadius, 16);
  const MeshNormals normals = blended(mesh, sphere_views());
  EXPECT_EQ(normals.measured, mesh.vertices.size());
  EXPECT_LT(sphere_error(mesh, normals), 0.1 * kDegree);
  ASSERT_EQ(normals.edges.size(), 6 * mesh.vertices.size() - 12);
  EXPECT_TRUE(std::none_of(normals.edges.begin(), normals.edges.end(),
                           [](const auto& normal) { return normal.isZero(); }));
}

TEST(MeshNormals, TheirExpectedErrorIsTheirError) {
  const TriangleMesh mesh = sphere_mesh(kRadius, 24);
  const MeshNormals normals = blended(mesh, sphere_views(3.0));
  double predicted = 0.0;
  for (const float sigma : normals.sigma) predicted += 2.0 * sigma * sigma;
  predicted = std::sqrt(predicted / static_cast<double>(mesh.vertices.size()));
  EXPECT_NEAR(sphere_error(mesh, normals) / predicted, 1.0, 0.2);
}

TEST(MeshNormals, OneViewWithWrongNormalsLosesItsSay) {
  const TriangleMesh mesh = sphere_mesh(kRadius, 16);
  std::vector<RangeView> views = sphere_views(1.0);
  for (const std::uint32_t seed : {10u, 20u, 30u}) {
    const std::vector<RangeView> again = sphere_views(1.0, seed);
    views.insert(views.end(), again.begin(), again.end());
  }
  const double before = sphere_error(mesh, blended(mesh, views));
  testing::add_normal_outliers(views[0], 0.3, 5);
  EXPECT_LT(sphere_error(mesh, blended(mesh, views)), 1.3 * before);
}

TEST(MeshNormals, WhatNoViewSawHasNone) {
  TriangleMesh mesh = sphere_mesh(kRadius, 12);
  std::vector<RangeView> views = sphere_views();
  views.resize(1);
  const MeshNormals normals = blended(mesh, views);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const double towards = mesh.vertices[i].x() / kRadius;
    if (towards < 0.0 || towards > 0.5) {
      EXPECT_EQ(normals.views[i], towards > 0.0 ? 1 : 0);
    }
  }
  mesh.filled.assign(mesh.vertices.size(), 1);
  EXPECT_EQ(blended(mesh, views).measured, 0u);
}

TEST(MeshNormals, ASurfaceBehindAnotherHasNone) {
  // A second, smaller sphere inside: no view sees it.
  const TriangleMesh mesh = sphere_mesh(0.8 * kRadius, 8);
  EXPECT_EQ(blended(mesh, sphere_views()).measured, 0u);
}

TEST(MeshNormals, TheOrderOfTheViewsAndTheThreadsDoNotMatter) {
  const TriangleMesh mesh = sphere_mesh(kRadius, 16);
  std::vector<RangeView> views = sphere_views(2.0);
  const MeshNormals normals = blended(mesh, views);
  std::reverse(views.begin(), views.end());
  const auto other = value_of(vertex_normals_from_views(mesh, views, {}, {.threads = 3}));
  EXPECT_EQ(std::memcmp(normals.normals.data(), other.normals.data(),
                        normals.normals.size() * sizeof(Eigen::Vector3f)),
            0);
}

// Views are asked by groups of vertices. Shuffled, each group spans the object.
TEST(MeshNormals, TheOrderOfTheVerticesDoesNotMatter) {
  const TriangleMesh mesh = sphere_mesh(kRadius, 32);
  std::vector<std::uint32_t> place(mesh.vertices.size());
  std::iota(place.begin(), place.end(), 0u);
  std::shuffle(place.begin(), place.end(), std::mt19937(3));
  TriangleMesh shuffled = mesh;
  for (std::size_t v = 0; v < place.size(); ++v) shuffled.vertices[place[v]] = mesh.vertices[v];
  for (auto& face : shuffled.faces)
    for (std::uint32_t& v : face) v = place[v];
  MeshNormalOptions options;
  options.sigma_view = 0.03;  // Else that of a sample of the vertices.
  const std::vector<RangeView> views = sphere_views(2.0);
  const auto normals = value_of(vertex_normals_from_views(mesh, views, options));
  const auto others = value_of(vertex_normals_from_views(shuffled, views, options));
  for (std::size_t v = 0; v < place.size(); ++v) {
    ASSERT_EQ(normals.views[v], others.views[place[v]]) << v;
    ASSERT_EQ(normals.normals[v], others.normals[place[v]]) << v;
  }
}

TEST(MeshNormals, ViewsWithoutNormalsSayNothing) {
  const TriangleMesh mesh = sphere_mesh(kRadius, 6);
  std::vector<RangeView> views = sphere_views();
  for (RangeView& view : views) view.normals = {};
  EXPECT_EQ(blended(mesh, views).measured, 0u);
  EXPECT_EQ(blended(mesh, {}).measured, 0u);
}

}  // namespace
}  // namespace relief::hybrid
