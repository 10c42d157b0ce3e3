#include "scan/mesh/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "scan/simulation/objects/geodesic_sphere.h"

namespace relief {
namespace {

Eigen::Vector3d random_vector(std::mt19937& generator, double size = 1.0) {
  std::uniform_real_distribution<double> uniform(-size, size);
  return {uniform(generator), uniform(generator), uniform(generator)};
}

TriangleMesh triangle_soup(int count, std::uint32_t seed) {
  std::mt19937 generator(seed);
  TriangleMesh mesh;
  for (std::uint32_t f = 0; f < static_cast<std::uint32_t>(count); ++f) {
    const Eigen::Vector3d centre = random_vector(generator);
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(centre + random_vector(generator, 0.1));
    mesh.faces.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  return mesh;
}

// The distance by minimising over a fine grid of the triangle: an upper bound, close from above.
double sampled_distance(const Eigen::Vector3d& query, const Eigen::Vector3d& a,
                        const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  double best = 1e300;
  constexpr int kSteps = 200;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps - i; ++j)
      best = std::min(best, (a + (b - a) * i / kSteps + (c - a) * j / kSteps - query).norm());
  return best;
}

TEST(ClosestOnTriangle, IsTheNearestPointOfTheTriangle) {
  std::mt19937 generator(3);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d a = random_vector(generator), b = random_vector(generator),
                          c = random_vector(generator), query = random_vector(generator, 2.0);
    const TrianglePoint closest = closest_on_triangle(query, a, b, c);
    EXPECT_NEAR(closest.weights.sum(), 1.0, 1e-12);
    EXPECT_GE(closest.weights.minCoeff(), 0.0);
    const Eigen::Vector3d& w = closest.weights;
    EXPECT_LT((w[0] * a + w[1] * b + w[2] * c - closest.point).norm(), 1e-12);
    const double sampled = sampled_distance(query, a, b, c);
    EXPECT_LE((closest.point - query).norm(), sampled + 1e-12);
    EXPECT_GT((closest.point - query).norm(), sampled - 0.02);
  }
}

TEST(ClosestOnTriangle, ServesTrianglesWithoutArea) {
  const Eigen::Vector3d a(0, 0, 0), b(2, 0, 0);
  for (const auto& [p, q, r] : {std::tuple{a, a, b}, {a, b, a}, {b, a, a}, {a, b, b}}) {
    const TrianglePoint closest = closest_on_triangle({0.5, 1, 0}, p, q, r);
    EXPECT_LT((closest.point - Eigen::Vector3d(0.5, 0, 0)).norm(), 1e-15);
  }
  EXPECT_EQ(closest_on_triangle({1, 1, 1}, a, a, a).point, a);
}

TEST(TriangleTree, ClosestMatchesBruteForce) {
  const TriangleMesh mesh = triangle_soup(500, 1);
  const TriangleTree tree(mesh);
  std::mt19937 generator(2);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d query = random_vector(generator, i < 400 ? 1.2 : 10.0);
    double best = 1e300;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
      best = std::min(
          best, (closest_on_triangle(query, mesh.corner(f, 0), mesh.corner(f, 1), mesh.corner(f, 2))
                     .point -
                 query)
                    .norm());
    const auto closest = tree.closest(query);
    ASSERT_TRUE(closest);
    EXPECT_EQ(closest->distance, best);
    EXPECT_FALSE(tree.closest(query, 0.99 * best));
    EXPECT_TRUE(tree.closest(query, 1.01 * best));
  }
}

TEST(TriangleTree, FirstHitMatchesBruteForce) {
  const TriangleMesh mesh = triangle_soup(2000, 4);
  const TriangleTree tree(mesh);
  std::mt19937 generator(5);
  int hits = 0;
  for (int i = 0; i < 1000; ++i) {
    const Ray ray{random_vector(generator, 2.0), random_vector(generator)};
    double best = 1e300;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      Eigen::Matrix3d system;
      system << mesh.corner(f, 1) - mesh.corner(f, 0), mesh.corner(f, 2) - mesh.corner(f, 0),
          -ray.direction;
      const Eigen::Vector3d x = system.inverse() * (ray.origin - mesh.corner(f, 0));
      if (x[0] >= 0 && x[1] >= 0 && x[0] + x[1] <= 1 && x[2] > 0) best = std::min(best, x[2]);
    }
    const auto hit = tree.first_hit(ray);
    ASSERT_EQ(hit.has_value(), best < 1e300) << i;
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->range, best, 1e-9 * best);
  }
  EXPECT_GT(hits, 100);
}

TEST(TriangleTree, RaysDoNotSlipThroughEdgesOrVertices) {
  const TriangleMesh sphere = simulation::geodesic_sphere(6);
  const TriangleTree tree(sphere);
  for (std::size_t f = 0; f < sphere.faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d vertex = sphere.corner(f, k);
      const Eigen::Vector3d middle = 0.5 * (vertex + sphere.corner(f, (k + 1) % 3));
      for (const Eigen::Vector3d& target : {vertex, middle}) {
        EXPECT_TRUE(tree.first_hit({Eigen::Vector3d::Zero(), target}));
        EXPECT_TRUE(tree.first_hit({4.0 * target, -target}));
      }
    }
  }
}

TEST(TriangleTree, ServesRaysAlongTheAxesOfFlatBoxes) {
  TriangleMesh square;
  square.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.faces = {{0, 1, 2}, {0, 2, 3}};
  const TriangleTree tree(square);
  for (const double x : {0.0, 0.25, 1.0}) {
    const auto hit = tree.first_hit({{x, 0.5, -2}, {0, 0, 4}});
    ASSERT_TRUE(hit) << x;
    EXPECT_EQ(hit->range, 0.5);
  }
  EXPECT_FALSE(tree.first_hit({{2, 0.5, -2}, {0, 0, 1}}));
  EXPECT_FALSE(tree.first_hit({{0.5, 0.5, 2}, {0, 0, 1}}));
}

// So many that its parts are built side by side; one more face or fewer shifts all halves.
TEST(TriangleTree, LargeOnesMatchBruteForceWithAnyNumberOfThreads) {
  for (const int count : {70000, 70001}) {
    TriangleMesh mesh = triangle_soup(count, 7);
    const auto tree_on = [&](int threads) {
      return on_threads(threads, [&] { return TriangleTree(mesh); });
    };
    const TriangleTree one = tree_on(1), three = tree_on(3);
    std::mt19937 generator(2);
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector3d query = random_vector(generator, 1.5);
      double best = 1e300;
      for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        best = std::min(best, (closest_on_triangle(query, mesh.corner(f, 0), mesh.corner(f, 1),
                                                   mesh.corner(f, 2))
                                   .point -
                               query)
                                  .norm());
      const auto by_one = one.closest(query), by_three = three.closest(query);
      ASSERT_TRUE(by_one && by_three);
      EXPECT_NEAR(by_one->distance, best, 1e-12);
      EXPECT_EQ(by_one->face, by_three->face);
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs[2];
    for (const auto& [tree, found] : {std::pair{&one, &pairs[0]}, {&three, &pairs[1]}})
      tree->visit_box_overlaps(0, 500, [list = found](std::uint32_t f, std::uint32_t g) {
        list->emplace_back(f, g);
        return true;
      });
    EXPECT_GT(pairs[0].size(), 500u);
    EXPECT_EQ(pairs[0], pairs[1]);
  }
}

TEST(TriangleTree, IsEmptyWithoutFaces) {
  const TriangleMesh mesh;
  const TriangleTree tree(mesh);
  EXPECT_FALSE(tree.closest({0, 0, 0}));
  EXPECT_FALSE(tree.first_hit({{0, 0, 0}, {0, 0, 1}}));
}

}  // namespace
}  // namespace relief
