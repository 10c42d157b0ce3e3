#include "scan/simulation/objects/built_in_object.h"

#include <cmath>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "scan/simulation/objects/geodesic_sphere.h"

namespace relief::simulation {
namespace {

// How often each undirected edge is used in either direction.
std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<int, int>> edge_uses(
    const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<int, int>> uses;
  for (const auto& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = face[k], b = face[(k + 1) % 3];
      auto& count = uses[std::minmax(a, b)];
      ++(a < b ? count.first : count.second);
    }
  }
  return uses;
}

class GeodesicSphere : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Divisions, GeodesicSphere, ::testing::Values(1, 2, 3, 7),
                         ::testing::PrintToStringParamName());

TEST_P(GeodesicSphere, IsAClosedOrientedSphere) {
  const TriangleMesh mesh = geodesic_sphere(GetParam());
  EXPECT_EQ(mesh.vertices.size(), 10u * GetParam() * GetParam() + 2u);
  EXPECT_EQ(mesh.faces.size(), 20u * GetParam() * GetParam());
  const auto uses = edge_uses(mesh);
  EXPECT_EQ(mesh.vertices.size() + mesh.faces.size(), uses.size() + 2u);  // genus 0
  for (const auto& [edge, count] : uses) EXPECT_EQ(count, std::pair(1, 1));
  for (const auto& vertex : mesh.vertices) EXPECT_NEAR(vertex.norm(), 1.0, 1e-15);
}

TEST(GeodesicSphere, ApproachesTheVolumeOfTheBallWithSecondOrder) {
  const double ball = 4.0 / 3.0 * std::numbers::pi;
  const double coarse = ball - enclosed_volume(geodesic_sphere(8));
  const double fine = ball - enclosed_volume(geodesic_sphere(16));
  EXPECT_GT(fine, 0.0);
  EXPECT_NEAR(coarse / fine, 4.0, 0.1);
}

TEST(BuiltInObject, GradientMatchesFiniteDifferences) {
  const AnalyticSurface owl = built_in_object();
  const double h = 1e-5;
  for (const auto& vertex : built_in_truth_mesh(20).vertices) {
    const Eigen::Vector3d p = 1.02 * vertex;
    Eigen::Vector3d difference;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(k);
      difference[k] = (owl.value(p + step) - owl.value(p - step)) / (2.0 * h);
    }
    EXPECT_LT((difference - owl.gradient(p)).norm(), 1e-6) << p.transpose();
  }
}

TEST(BuiltInObject, KeepsTheBoundsThatRayCastingReliesOn) {
  const AnalyticSurface owl = built_in_object();
  double steepest = 0.0, farthest = 0.0;
  for (const auto& vertex : built_in_truth_mesh(300).vertices) {
    farthest = std::max(farthest, vertex.norm());
    steepest = std::max(steepest, owl.gradient(vertex).norm());
  }
  // Along a ray from the origin the tangential part of the gradient falls with the distance, so the
  // surface is the steepest place outside.
  EXPECT_LT(steepest, owl.lipschitz);
  EXPECT_LT(farthest, owl.bounding_radius);
}

TEST(BuiltInObject, NormalsAreContinuous) {
  const TriangleMesh mesh = built_in_truth_mesh(256);
  const PagedVector<Eigen::Vector3f> faceted = vertex_normals(mesh);
  double largest = 0.0;
  for (std::size_t i = 0; i < faceted.size(); ++i)
    largest = std::max(largest, static_cast<double>((faceted[i] - mesh.normals[i]).norm()));
  EXPECT_LT(largest, 0.2);
}

TEST(BuiltInObject, TruthMeshIsClosedAndOnTheSurface) {
  const AnalyticSurface owl = built_in_object();
  const TriangleMesh mesh = built_in_truth_mesh(40);
  Eigen::Vector3d low = mesh.vertices[0], high = low;
  for (const auto& vertex : mesh.vertices) {
    EXPECT_LT(std::abs(owl.value(vertex)), 1e-12 * owl.bounding_radius);
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  for (const auto& [edge, count] : edge_uses(mesh)) EXPECT_EQ(count, std::pair(1, 1));
  EXPECT_NEAR((high - low).maxCoeff(), 97.0, 3.0);
  EXPECT_GT(enclosed_volume(mesh), 2.5e5);
}

}  // namespace
}  // namespace relief::simulation
