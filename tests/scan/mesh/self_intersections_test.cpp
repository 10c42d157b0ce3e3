#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "relief/scan/mesh_check.h"
#include "scan/mesh/triangle_overlap.h"
#include "scan/simulation/objects/geodesic_sphere.h"

namespace relief {
namespace {

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b, const Eigen::Vector3d& shift) {
  TriangleMesh mesh = a;
  const auto offset = static_cast<std::uint32_t>(a.vertices.size());
  for (const auto& p : b.vertices) mesh.vertices.push_back(p + shift);
  for (const auto& f : b.faces) mesh.faces.push_back({f[0] + offset, f[1] + offset, f[2] + offset});
  return mesh;
}

std::vector<std::array<std::uint32_t, 2>> by_brute_force(const TriangleMesh& mesh) {
  const auto triangle = [&](std::uint32_t f) {
    return Triangle{mesh.corner(f, 0), mesh.corner(f, 1), mesh.corner(f, 2)};
  };
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
    for (std::uint32_t g = f + 1; g < mesh.faces.size(); ++g)
      if (overlap(triangle(f), triangle(g))) pairs.push_back({f, g});
  return pairs;
}

TEST(SelfIntersections, ASphereHasNone) {
  const auto found = find_self_intersections(simulation::geodesic_sphere(40));
  EXPECT_TRUE(found.pairs.empty());
  EXPECT_TRUE(found.complete);
}

TEST(SelfIntersections, AgreeWithBruteForce) {
  const TriangleMesh sphere = simulation::geodesic_sphere(6);
  const TriangleMesh two = joined(sphere, sphere, {0.7, 0.31, 0.17});
  const auto found = find_self_intersections(two);
  EXPECT_GT(found.pairs.size(), 50u);
  EXPECT_EQ(found.pairs, by_brute_force(two));
}

TEST(SelfIntersections, OfRandomTrianglesAgreeWithBruteForce) {
  std::mt19937 generator(3);
  std::uniform_int_distribution<int> coordinate(0, 7);
  TriangleMesh soup;
  while (soup.faces.size() < 300) {
    Triangle t;
    for (auto& p : t)
      p = {double(coordinate(generator)), double(coordinate(generator)),
           double(coordinate(generator))};
    if (collinear(t)) continue;
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), t.begin(), t.end());
    soup.faces.push_back({first, first + 1, first + 2});
  }
  EXPECT_EQ(find_self_intersections(soup).pairs, by_brute_force(soup));
}

TEST(SelfIntersections, NameTheFaces) {
  // A spike through the opposite side: the fan of one vertex crosses what it meets.
  TriangleMesh mesh = simulation::geodesic_sphere(4);
  const TriangleMesh sphere = mesh;
  mesh.vertices[0] *= -1.5;
  const auto found = find_self_intersections(mesh);
  ASSERT_FALSE(found.pairs.empty());
  const auto has_vertex_0 = [&](std::uint32_t f) {
    return std::find(mesh.faces[f].begin(), mesh.faces[f].end(), 0u) != mesh.faces[f].end();
  };
  for (const auto& [f, g] : found.pairs) EXPECT_NE(has_vertex_0(f), has_vertex_0(g));
  EXPECT_TRUE(std::is_sorted(found.pairs.begin(), found.pairs.end()));
  const auto faces = found.faces();
  EXPECT_TRUE(std::is_sorted(faces.begin(), faces.end()));
  EXPECT_EQ(std::adjacent_find(faces.begin(), faces.end()), faces.end());
}

TEST(SelfIntersections, DoNotAskWhetherAMeshIsWelded) {
  const TriangleMesh sphere = simulation::geodesic_sphere(8);
  TriangleMesh soup;
  for (std::size_t f = 0; f < sphere.faces.size(); ++f) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (int k = 0; k < 3; ++k) soup.vertices.push_back(sphere.corner(f, k));
    soup.faces.push_back({first, first + 1, first + 2});
  }
  EXPECT_TRUE(find_self_intersections(soup).pairs.empty());
}

TEST(SelfIntersections, ACopyCoversEveryFace) {
  const TriangleMesh sphere = simulation::geodesic_sphere(5);
  const auto count = static_cast<std::uint32_t>(sphere.faces.size());
  const auto found = find_self_intersections(joined(sphere, sphere, Eigen::Vector3d::Zero()));
  ASSERT_EQ(found.pairs.size(), sphere.faces.size());
  for (const auto& [f, g] : found.pairs) EXPECT_EQ(f + count, g);
}

TEST(SelfIntersections, StopAtTheLimit) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces.assign(3000, {0, 1, 2});  // 4.5 million pairs
  const auto found = find_self_intersections(mesh, {.limit = 1000});
  EXPECT_EQ(found.pairs.size(), 1000u);
  EXPECT_FALSE(found.complete);
  EXPECT_EQ(on_threads(3, [&] { return find_self_intersections(mesh, {.limit = 1000}); }).pairs,
            found.pairs);
}

TEST(SelfIntersections, DoNotDependOnTheThreads) {
  const TriangleMesh sphere = simulation::geodesic_sphere(40);
  const TriangleMesh two = joined(sphere, sphere, {0.7, 0.31, 0.17});
  const auto found_on = [&](int threads) {
    return on_threads(threads, [&] { return find_self_intersections(two); });
  };
  const auto one = found_on(1);
  EXPECT_GT(one.pairs.size(), 300u);
  EXPECT_EQ(found_on(4).pairs, one.pairs);
}

TEST(SelfIntersections, LeaveOutWhatIsNoTriangle) {
  EXPECT_TRUE(find_self_intersections({}).pairs.empty());
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.5, 0}, {0.1, 0.1, 0}};
  mesh.faces = {{0, 1, 2}, {1, 3, 2}, {0, 0, 4}, {0, 1, 99}};
  EXPECT_TRUE(find_self_intersections(mesh).pairs.empty());
  mesh.vertices[4].x() = std::numeric_limits<double>::quiet_NaN();
  mesh.faces.push_back({0, 1, 4});
  EXPECT_TRUE(find_self_intersections(mesh).pairs.empty());
  // What comes after such faces keeps its number.
  mesh.vertices.emplace_back(0.2, 0.2, 1.0);
  mesh.vertices.emplace_back(0.2, 0.2, -1.0);
  mesh.faces.push_back({3, 5, 6});
  const auto found = find_self_intersections(mesh);
  ASSERT_EQ(found.pairs.size(), 1u);
  EXPECT_EQ(found.pairs[0], (std::array<std::uint32_t, 2>{0, 5}));
}

}  // namespace
}  // namespace relief
