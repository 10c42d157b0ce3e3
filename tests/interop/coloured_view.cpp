#include "tests/interop/coloured_view.h"

#include <gtest/gtest.h>

#include "tests/support/scenes/small_meshes.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::testing {

namespace {

RigidMotion some_pose() { return look_at({8, 1, 2}, {0, 0, 0}); }

// Moves along x and is a perspective camera in the plane across.
Camera line_scanner() {
  const RationalProjection projection{{10, 0, 0, 20}, {0, 0, 0, 1}, {0, 60, 20, 0}, {0, 0, 1, 0}};
  Grid<Ray> rays(40, 40);
  for (int v = 0; v < 40; ++v)
    for (int u = 0; u < 40; ++u) rays(u, v) = projection.ray(u, v, Eigen::Vector3d::UnitZ());
  return Camera::ray_table(std::move(rays), projection);
}

}  // namespace

std::vector<Camera> cameras_of_all_models() {
  const PinholeIntrinsics intrinsics{60, 62, 23.5, 17.5};
  return {
      Camera::pinhole(48, 36, intrinsics), Camera::pinhole_gl(48, 36, intrinsics),
      Camera::orthographic(40, 40, {-2, -2, 1}, {0.1, 0, 0}, {0, 0.1, 0}, Eigen::Vector3d::UnitZ()),
      line_scanner()};
}

RangeView coloured_view(const Camera& camera) {
  const double side = camera.model() == Camera::Model::kPinholeGl ? -8.0 : 8.0;
  const RigidMotion pose = some_pose();
  RangeView view = render(sphere(pose * Eigen::Vector3d(0, 0, side), 1.87), camera, pose);
  view.name = "front";
  view.pose = PoseKind::kGuess;
  if (camera.model() == Camera::Model::kOrthographic) view.samples = SampleOrigin::kRefined;
  view.confidence = Grid<float>(view.width(), view.height(), 0.75f);
  view.deviation = Grid<float>(view.width(), view.height(), 0.125f);
  view.colours = Grid<Colour>(view.width(), view.height());
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      view.colours(u, v) = {static_cast<std::uint8_t>(5 * u), static_cast<std::uint8_t>(6 * v),
                            200};
  view.normals(view.width() / 2, view.height() / 2).setConstant(static_cast<float>(kNoSample));
  return view;
}

TriangleMesh mesh_with_attributes() { return with_attributes(tetrahedron()); }

void expect_same_samples(const RangeView& found, const RangeView& given, double tolerance) {
  ASSERT_EQ(found.width(), given.width());
  ASSERT_EQ(found.height(), given.height());
  ASSERT_EQ(found.has_normals(), given.has_normals());
  EXPECT_EQ(found.pose, given.pose);
  EXPECT_TRUE(found.world_from_view.isApprox(given.world_from_view, tolerance));
  ASSERT_GT(given.sample_count(), 300u);
  for (int v = 0; v < given.height(); ++v) {
    for (int u = 0; u < given.width(); ++u) {
      ASSERT_EQ(found.has_sample(u, v), given.has_sample(u, v));
      if (!given.has_sample(u, v)) continue;
      const Eigen::Vector3d p = given.point(u, v), d = given.camera.ray(u, v).direction;
      ASSERT_NEAR((found.point(u, v) - p).norm(), 0.0, tolerance * p.norm());
      ASSERT_NEAR((found.camera.ray(u, v).direction.normalized() - d.normalized()).norm(), 0.0,
                  10 * tolerance);
      ASSERT_EQ(found.has_normal(u, v), given.has_normal(u, v));
      if (!given.has_normal(u, v)) continue;
      ASSERT_NEAR((found.normals(u, v) - given.normals(u, v)).norm(), 0.0f, 1e-6f);
    }
  }
}

void expect_same_mesh(const TriangleMesh& found, const TriangleMesh& given, double tolerance) {
  ASSERT_EQ(found.vertices.size(), given.vertices.size());
  for (std::size_t i = 0; i < given.vertices.size(); ++i)
    EXPECT_NEAR((found.vertices[i] - given.vertices[i]).norm(), 0.0, tolerance);
  EXPECT_EQ(found.faces, given.faces);
  EXPECT_EQ(found.normals, given.normals);
  EXPECT_EQ(found.quality, given.quality);
  EXPECT_EQ(found.views, given.views);
  EXPECT_EQ(found.filled, given.filled);
  EXPECT_EQ(found.colours, given.colours);
}

}  // namespace relief::testing
