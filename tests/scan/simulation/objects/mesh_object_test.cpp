#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "relief/simulation/simulate.h"
#include "relief/simulation/simulation_object.h"
#include "scan/simulation/objects/built_in_object.h"
#include "scan/simulation/objects/geodesic_sphere.h"
#include "tests/support/result_matchers.h"

namespace relief::simulation {
namespace {

TEST(MeshObject, IsSeenWhereTheAnalyticObjectIs) {
  SimulationOptions options;
  options.views = 3;
  options.width = options.height = 64;
  const auto exact = simulate(built_in_simulation_object(0), options);
  auto object = value_of(mesh_object(built_in_truth_mesh(150)));
  // The same cameras as for the analytic object.
  object.centre.setZero();
  object.radius = exact->diameter / 2.0;
  const auto meshed = simulate(object, options);
  ASSERT_TRUE(exact && meshed);
  std::size_t both = 0, one = 0, far = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const RangeView &a = exact->truth.views[i], &b = meshed->truth.views[i];
    for (int v = 0; v < 64; ++v) {
      for (int u = 0; u < 64; ++u) {
        one += a.has_sample(u, v) != b.has_sample(u, v);
        if (!a.has_sample(u, v) || !b.has_sample(u, v)) continue;
        ++both;
        far += (a.point(u, v) - b.point(u, v)).norm() > 0.1;
      }
    }
  }
  EXPECT_GT(both, 3000u);
  EXPECT_LT(one, both / 50);
  EXPECT_LT(far, both / 50);
}

TEST(MeshObject, IsFramedByItsOwnSphere) {
  TriangleMesh mesh = geodesic_sphere(20);
  for (auto& vertex : mesh.vertices) vertex = 0.02 * vertex + Eigen::Vector3d(5, 6, 7);
  const auto object = value_of(mesh_object(mesh, "m"));
  EXPECT_NEAR(object.radius, 0.02, 1e-3);
  SimulationOptions options;
  options.views = 2;
  options.width = options.height = 100;
  const auto simulation = value_of(simulate(object, options));
  EXPECT_EQ(simulation.truth.unit, "m");
  EXPECT_EQ(simulation.mesh.faces.size(), mesh.faces.size());
  const RangeView& view = simulation.truth.views[0];
  int widest = 0;
  for (int v = 0; v < 100; ++v) {
    int width = 0;
    for (int u = 0; u < 100; ++u) width += view.has_sample(u, v);
    widest = std::max(widest, width);
  }
  // Up to the incidence limit of 80 degrees.
  EXPECT_NEAR(widest, 0.95 * 100.0 * std::sin(80.0 * std::acos(-1.0) / 180.0), 3.0);
}

TEST(MeshObject, NeedsASurface) {
  EXPECT_THAT(mesh_object({}), HasError(ErrorKind::kBadInput));
  TriangleMesh broken = geodesic_sphere(1);
  broken.vertices[3].x() = std::nan("");
  EXPECT_THAT(mesh_object(broken), HasError("vertex 3"));
}

}  // namespace
}  // namespace relief::simulation
