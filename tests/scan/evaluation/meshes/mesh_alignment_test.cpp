#include <cmath>

#include <gtest/gtest.h>

#include "relief/evaluation/mesh_errors.h"
#include "scan/simulation/objects/geodesic_sphere.h"
#include "tests/support/result_matchers.h"

namespace relief::evaluation {
namespace {

RigidMotion motion(double a, double b, double c, double x, double y, double z) {
  return motion_from_tangent((RigidTangent() << a, b, c, x, y, z).finished());
}

// A sphere with bumps of no symmetry.
TriangleMesh potato(int divisions = 30) {
  TriangleMesh mesh = simulation::geodesic_sphere(divisions);
  for (auto& p : mesh.vertices) {
    const double bumps = 0.2 * std::sin(3.0 * p.x() + 1.0) + 0.15 * std::cos(4.0 * p.y() + p.z()) +
                         0.1 * std::sin(5.0 * p.z() - 2.0 * p.x());
    p *= 10.0 * (1.0 + bumps);
  }
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, const RigidMotion& by) {
  for (auto& p : mesh.vertices) p = by * p;
  return mesh;
}

TEST(AlignMesh, UndoesASmallMotionExactly) {
  const RigidMotion by = motion(0.02, -0.03, 0.01, 0.1, 0.2, -0.1);
  const auto fit = value_of(align_mesh(moved(potato(), by), potato(), {.any_start = false}));
  EXPECT_TRUE(fit.converged);
  EXPECT_LT(((fit.truth_from_result * by).matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-8);
}

TEST(AlignMesh, UndoesAnyMotion) {
  for (const RigidMotion& by : {motion(2.5, 0.5, -1.0, 100, -50, 30), motion(0, 3.1, 0, 0, 0, 7)}) {
    const TriangleMesh result = moved(potato(), by);
    const auto fit = value_of(align_mesh(result, potato()));
    EXPECT_LT(((fit.truth_from_result * by).matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-7);
    const auto comparison =
        value_of(compare_meshes(moved(result, fit.truth_from_result), potato(), {.samples = 2000}));
    EXPECT_LT(comparison.accuracy.all.distance.max, 1e-7);
    EXPECT_LT(comparison.completeness.all.distance.max, 1e-7);
  }
}

TEST(AlignMesh, IsNotPulledByWhatOnlyOneMeshHas) {
  TriangleMesh result = potato();
  std::erase_if(result.faces, [&](const auto& face) { return result.vertices[face[0]].z() > 4.0; });
  TriangleMesh junk = simulation::geodesic_sphere(5);
  const auto offset = static_cast<std::uint32_t>(result.vertices.size());
  for (const auto& p : junk.vertices)
    result.vertices.push_back(2.0 * p + Eigen::Vector3d(0, 20, 0));
  for (const auto& f : junk.faces)
    result.faces.push_back({f[0] + offset, f[1] + offset, f[2] + offset});
  const RigidMotion by = motion(0.03, -0.02, 0.02, 0.3, 0.1, -0.2);
  const auto fit = value_of(align_mesh(moved(result, by), potato(), {.any_start = false}));
  EXPECT_LT(((fit.truth_from_result * by).matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-6);
}

TEST(AlignMesh, DoesNotDependOnThreads) {
  const TriangleMesh result = moved(potato(10), motion(1.0, 0.5, -1.0, 1, 2, 3));
  const auto one = align_mesh(result, potato(10), {.samples = 1000}, {.threads = 1});
  const auto three = align_mesh(result, potato(10), {.samples = 1000}, {.threads = 3});
  ASSERT_TRUE(one && three);
  EXPECT_EQ(one->truth_from_result.matrix(), three->truth_from_result.matrix());
}

TEST(AlignMesh, RefusesMeshesWithoutArea) {
  EXPECT_FALSE(align_mesh({}, potato(5)));
  EXPECT_FALSE(align_mesh(potato(5), {}));
}

}  // namespace
}  // namespace relief::evaluation
