#include "scan/io/grids/cameras/grid_camera.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scan/io/grids/cameras/camera_fit.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

using testing::render;
using testing::sphere;

GridFile grid_of(const RangeView& view) { return {points_of(view), {}, {}}; }

// What a laser line scanner sees of a sphere seen from +z: it moves along x, and is a perspective
// camera at distance `focus` in the plane across.
GridFile line_scan(double focus) {
  const int size = 80;
  GridFile grid;
  grid.points = Grid<Eigen::Vector3d>(size, size, Eigen::Vector3d::Constant(kNoSample));
  const auto surface = sphere({0, 0, 0}, 0.9);
  for (int v = 0; v < size; ++v) {
    for (int u = 0; u < size; ++u) {
      const Ray ray{{(u - 40) / 40.0, 0, focus}, {0, (v - 40) / (40.0 * focus), -1}};
      if (const auto hit = surface(ray)) grid.points(u, v) = ray.at(hit->t);
    }
  }
  return grid;
}

double largest_change(const GridFile& grid, const GridCamera& fitted) {
  double largest = 0.0;
  for (int v = 0; v < grid.points.height(); ++v)
    for (int u = 0; u < grid.points.width(); ++u)
      if (grid.points(u, v).allFinite())
        largest = std::max(
            largest, (fitted.camera.ray(u, v).at(fitted.range(u, v)) - grid.points(u, v)).norm());
  return largest;
}

TEST(GridCamera, FindsPinholes) {
  const PinholeIntrinsics k{90, 95, 30.5, 24};
  const RangeView forward = render(sphere({0, 0, 10}, 3), Camera::pinhole(64, 48, k));
  const RangeView backward = render(sphere({0, 0, -10}, 3), Camera::pinhole_gl(64, 48, k));
  for (const RangeView& view : {forward, backward}) {
    const FittedCamera fitted = fit_camera(grid_of(view));
    EXPECT_EQ(fitted.model.model(), view.camera.model()) << fitted.description;
    EXPECT_NEAR(fitted.model.intrinsics().fx, k.fx, 1e-6);
    EXPECT_NEAR(fitted.model.intrinsics().cy, k.cy, 1e-6);
    const GridCamera through = camera_through_points(points_of(view), fitted.model);
    EXPECT_TRUE(through.exact_model);
    EXPECT_LT(largest_change(grid_of(view), through), 1e-9);
  }
}

TEST(GridCamera, FindsPinholesOfMirroredFrames) {
  const PinholeIntrinsics k{90, -95, 30.5, 24};
  const RangeView view = render(sphere({0, 0, 10}, 3), Camera::pinhole(64, 48, k));
  const FittedCamera fitted = fit_camera(grid_of(view));
  EXPECT_EQ(fitted.model.model(), Camera::Model::kPinhole) << fitted.description;
  EXPECT_NEAR(fitted.model.intrinsics().fy, k.fy, 1e-6);
}

TEST(GridCamera, FindsAnOrthographicDirection) {
  const Eigen::Vector3d direction = Eigen::Vector3d(0.3, -0.2, -1).normalized();
  const Eigen::Vector3d across = direction.unitOrthogonal();
  const Camera camera =
      Camera::orthographic(60, 50, -3 * direction - 1.5 * across - 1.2 * direction.cross(across),
                           0.05 * across, 0.05 * direction.cross(across), direction);
  const RangeView view = render(sphere({0, 0, 0}, 1), camera);
  ASSERT_GT(view.sample_count(), 500u);
  const FittedCamera fitted = fit_camera(grid_of(view));
  ASSERT_EQ(fitted.model.model(), Camera::Model::kOrthographic) << fitted.description;
  EXPECT_NEAR((fitted.model.ray(0, 0).direction - direction).norm(), 0.0, 1e-6);
}

TEST(GridCamera, FindsALineScannerAndWhichSideItIsOn) {
  const GridFile grid = line_scan(5.0);
  const FittedCamera fitted = fit_camera(grid);
  ASSERT_EQ(fitted.model.model(), Camera::Model::kRayTable) << fitted.description;
  EXPECT_LT(fitted.model.ray(40, 40).direction.z(), -0.999);
  const GridCamera through = camera_through_points(grid.points, fitted.model);
  EXPECT_LT(through.rms_pixels, 1e-3);
  EXPECT_TRUE(through.camera.can_project());
  EXPECT_LT(largest_change(grid, through), 1e-12);
  for (const double t : through.range) EXPECT_FALSE(t <= 0.0);
  // Rays of pixels without samples fan out like the true ones.
  const Eigen::Vector3d corner = through.camera.ray(2, 2).direction;
  EXPECT_NEAR(corner.y() / -corner.z(), (2 - 40) / (40.0 * 5.0), 1e-4);
}

// A sensor at -z sees the same scanner's picture diverge towards +z.
TEST(GridCamera, PerspectiveTellsTheSideAgainstTheCustom) {
  GridFile grid = line_scan(5.0);
  for (auto& point : grid.points) point.z() = -point.z();
  EXPECT_GT(fit_camera(grid).model.ray(40, 40).direction.z(), 0.999);
}

TEST(GridCamera, NormalsTellTheSideOfParallelRays) {
  const Camera camera = Camera::orthographic(40, 40, {-1, -1, -5}, {0.05, 0, 0}, {0, 0.05, 0},
                                             Eigen::Vector3d::UnitZ());
  const RangeView view = render(sphere({0, 0, 0}, 0.9), camera);
  GridFile grid = grid_of(view);
  EXPECT_LT(fit_camera(grid).model.ray(0, 0).direction.z(), -0.99) << "custom: z to the viewer";
  grid.normals = view.normals;
  EXPECT_GT(fit_camera(grid).model.ray(0, 0).direction.z(), 0.99);
}

TEST(GridCamera, NormalsOfAWrongConventionTellNoSide) {
  const Camera camera = Camera::orthographic(80, 80, {-1, -1, 5}, {0.025, 0, 0}, {0, 0.025, 0},
                                             -Eigen::Vector3d::UnitZ());
  const RangeView view = render(sphere({0, 0, 0}, 0.9), camera);
  GridFile grid = grid_of(view);
  grid.normals = view.normals;
  for (auto& normal : grid.normals) normal.z() = -normal.z();
  EXPECT_LT(fit_camera(grid).model.ray(0, 0).direction.z(), -0.99);
}

TEST(GridCamera, PerspectiveTellsTheSideAgainstReversedNormals) {
  GridFile grid = line_scan(5.0);
  grid.normals = Grid<Eigen::Vector3f>(80, 80, Eigen::Vector3f::Constant(NAN));
  for (std::size_t i = 0; i < grid.points.size(); ++i)
    if (grid.points[i].allFinite()) grid.normals[i] = -grid.points[i].normalized().cast<float>();
  EXPECT_LT(fit_camera(grid).model.ray(40, 40).direction.z(), -0.999);
}

TEST(GridCamera, AGivenDirectionIsKeptAndPointsStayExact) {
  const GridFile grid = line_scan(5.0);
  const Camera model = fit_orthographic(grid.points, -Eigen::Vector3d::UnitZ());
  const GridCamera through = camera_through_points(grid.points, model);
  EXPECT_EQ(through.camera.model(), Camera::Model::kRayTable);
  EXPECT_FALSE(through.exact_model);
  EXPECT_LT(largest_change(grid, through), 1e-14);
  EXPECT_EQ(through.camera.ray(3, 70).direction, -Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(through.camera.can_project());
}

TEST(GridCamera, PointsBesideThePinholeRaysAreNotMoved) {
  const PinholeIntrinsics k{90, 95, 30.5, 24};
  RangeView view = render(sphere({0, 0, 10}, 3), Camera::pinhole(64, 48, k));
  GridFile grid = grid_of(view);
  for (auto& point : grid.points) point.x() += 0.02;
  const GridCamera through = camera_through_points(grid.points, view.camera);
  EXPECT_FALSE(through.exact_model);
  EXPECT_LT(largest_change(grid, through), 1e-12);
  EXPECT_TRUE(through.camera.can_project());
}

TEST(GridCamera, FewOrFlatPointsStillGiveACamera) {
  GridFile one{Grid<Eigen::Vector3d>(4, 3, Eigen::Vector3d::Constant(kNoSample)), {}, {}};
  one.points(2, 1) = {1, 2, 3};
  GridFile flat{Grid<Eigen::Vector3d>(10, 10, Eigen::Vector3d::Zero()), {}, {}};
  for (int v = 0; v < 10; ++v)
    for (int u = 0; u < 10; ++u) flat.points(u, v) = {0.1 * u, 0.1 * v, 0.0};
  GridFile row = flat;
  for (int v = 1; v < 10; ++v)
    for (int u = 0; u < 10; ++u) row.points(u, v) = Eigen::Vector3d::Constant(kNoSample);
  const GridFile none{Grid<Eigen::Vector3d>(4, 3, Eigen::Vector3d::Constant(kNoSample)), {}, {}};
  for (const GridFile& grid : {one, flat, row, none}) {
    const GridCamera through = camera_through_points(grid.points, fit_camera(grid).model);
    EXPECT_LT(largest_change(grid, through), 1e-9);
    for (int v = 0; v < grid.points.height(); ++v)
      for (int u = 0; u < grid.points.width(); ++u) {
        EXPECT_TRUE(through.camera.ray(u, v).origin.allFinite());
        EXPECT_NEAR(through.camera.ray(u, v).direction.norm(), 1.0, 0.5);
      }
  }
}

}  // namespace
}  // namespace relief
