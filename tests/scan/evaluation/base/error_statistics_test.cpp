#include "relief/evaluation/error_statistics.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "scan/evaluation/meshes/surface_samples.h"
#include "scan/simulation/objects/geodesic_sphere.h"

namespace relief::evaluation {
namespace {

TEST(Summarize, GivesTheStatisticsOfMagnitudes) {
  std::vector<double> errors;
  for (int i = 1; i <= 100; ++i) errors.push_back(i % 2 == 0 ? i : -i);
  const ErrorStatistics statistics = summarize(errors);
  EXPECT_EQ(statistics.count, 100u);
  EXPECT_DOUBLE_EQ(statistics.mean, 50.5);
  EXPECT_EQ(statistics.median, 50.0);
  EXPECT_EQ(statistics.p95, 95.0);
  EXPECT_EQ(statistics.max, 100.0);
  EXPECT_NEAR(statistics.rms, std::sqrt(3383.5), 1e-12);
}

TEST(Summarize, IsZeroWithoutErrors) {
  const ErrorStatistics statistics = summarize({});
  EXPECT_EQ(statistics.count, 0u);
  EXPECT_EQ(statistics.rms, 0.0);
  EXPECT_EQ(summarize({-3.0}).median, 3.0);
}

TEST(SampleSurface, SpreadsPointsByArea) {
  // Two squares, the second nine times as large.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                   {5, 0, 0}, {8, 0, 0}, {8, 3, 0}, {5, 3, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  const auto samples = sample_surface(mesh, 20000, 1);
  ASSERT_EQ(samples.size(), 20000u);
  std::size_t on_small = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& sample : samples) {
    EXPECT_NEAR(sample.weights.sum(), 1.0, 1e-12);
    EXPECT_GE(sample.weights.minCoeff(), 0.0);
    on_small += sample.face < 2;
    mean += point_at(mesh, sample) / 20000.0;
  }
  EXPECT_NEAR(static_cast<double>(on_small), 2000.0, 1.0);  // stratified, not only on average
  EXPECT_NEAR(mean.x(), 0.1 * 0.5 + 0.9 * 6.5, 0.02);
  EXPECT_NEAR(mean.y(), 0.1 * 0.5 + 0.9 * 1.5, 0.02);
}

TEST(SampleSurface, IsAFunctionOfTheSeed) {
  const TriangleMesh mesh = simulation::geodesic_sphere(3);
  const auto a = sample_surface(mesh, 500, 1), b = sample_surface(mesh, 500, 1),
             c = sample_surface(mesh, 500, 2);
  std::size_t equal = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].weights, b[i].weights);
    equal += a[i].weights == c[i].weights;
  }
  EXPECT_EQ(equal, 0u);
}

TEST(SampleSurface, IsEmptyWithoutArea) {
  TriangleMesh mesh;
  EXPECT_TRUE(sample_surface(mesh, 10, 1).empty());
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  mesh.faces = {{0, 1, 2}};
  EXPECT_TRUE(sample_surface(mesh, 10, 1).empty());
}

}  // namespace
}  // namespace relief::evaluation
