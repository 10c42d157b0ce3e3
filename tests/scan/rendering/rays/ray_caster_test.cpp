#include "scan/rendering/rays/ray_caster.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/base/counter_random.h"
#include "scan/mesh/triangle_tree.h"
#include "tests/scan/rendering/shapes.h"
#include "tests/support/result_matchers.h"

namespace relief::rendering {
namespace {

using testing::plate;
using testing::sphere;

TEST(RayCaster, HitsWhatTheExactTreeHits) {
  const TriangleMesh mesh = sphere(40.0, {500.0, -300.0, 20.0}, 12);
  const auto caster = value_of(RayCaster::of(mesh));
  const TriangleTree tree(mesh);
  const CounterRandom random(1, 2);
  int hits = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Eigen::Vector3d from(random.normal(6 * i), random.normal(6 * i + 1),
                               random.normal(6 * i + 2));
    const Eigen::Vector3d to(random.uniform(12 * i + 6), random.uniform(12 * i + 7),
                             random.uniform(12 * i + 8));
    const Eigen::Vector3d origin = Eigen::Vector3d(500.0, -300.0, 20.0) + 200.0 * from.normalized();
    const Ray ray{origin, 3.0 * (Eigen::Vector3d(500.0, -300.0, 20.0) + 70.0 * to - origin)};
    const auto hit = caster.first_hit(ray, true);
    const auto expected = tree.first_hit(ray);
    ASSERT_EQ(hit.has_value(), expected.has_value()) << i;
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->range, expected->range, 1e-5) << i;
    EXPECT_NEAR(hit->weights.sum(), 1.0, 1e-12);
  }
  EXPECT_GT(hits, 200);
  EXPECT_LT(hits, 1900);
}

TEST(RayCaster, NoRaySlipsThroughBetweenFaces) {
  // Rays at vertices and along edges, where a test of single faces would lose some.
  const TriangleMesh mesh = sphere(1.0, {0, 0, 0}, 20);
  const auto caster = value_of(RayCaster::of(mesh));
  const Eigen::Vector3d eye(0.0, -5.0, 0.3);
  for (const auto& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d a = mesh.vertices[face[k]], b = mesh.vertices[face[(k + 1) % 3]];
      for (const double share : {0.0, 0.25, 0.5}) {
        const Eigen::Vector3d place = 0.99 * ((1.0 - share) * a + share * b);
        EXPECT_TRUE(caster.first_hit({eye, place - eye}, true));
      }
    }
  }
}

TEST(RayCaster, LooksForwardFromASensorAndBothWaysAlongALine) {
  const auto caster = value_of(RayCaster::of(plate(1.0)));
  const Ray away{{0.2, 0.3, 5.0}, {0, 0, 2}};
  EXPECT_FALSE(caster.first_hit(away, true));
  const auto behind = caster.first_hit(away, false);
  ASSERT_TRUE(behind);
  EXPECT_NEAR(behind->range, -2.5, 1e-6);
}

TEST(RayCaster, KeepsAccuracyFarFromTheOrigin) {
  // In floats of the world the sphere would have the shape of a cube.
  const Eigen::Vector3d centre(4e6, -2e6, 1e6);
  const auto caster = value_of(RayCaster::of(sphere(1.0, centre)));
  const auto hit = caster.first_hit({centre + Eigen::Vector3d(0, 0, 7), {0, 0, -1}}, true);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range, 6.0, 1e-5);
}

TEST(RayCaster, NamesWhatIsWrongWithAMesh) {
  EXPECT_THAT(RayCaster::of({}), HasError("no faces"));
  TriangleMesh broken = plate(1.0);
  broken.vertices[2].x() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(RayCaster::of(broken), HasError("vertex 2"));
  TriangleMesh dangling = plate(1.0);
  dangling.faces[1][2] = 4;
  EXPECT_THAT(RayCaster::of(dangling), HasError("face 1 of the mesh names vertex 4"));
  TriangleMesh point = plate(1.0);
  for (auto& vertex : point.vertices) vertex.setOnes();
  EXPECT_THAT(RayCaster::of(point), HasError("no extent"));
}

}  // namespace
}  // namespace relief::rendering
