#include "scan/io/grids/grid_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

const Camera kCamera = Camera::pinhole(48, 36, {60, 62, 23.5, 17.5});

RangeView sphere_view() { return testing::render(testing::sphere({0, 0, 8}, 2.0), kCamera); }

GridFile grid_of(const RangeView& view) {
  GridFile grid;
  grid.points = points_of(view);
  grid.normals = view.normals;
  return grid;
}

TEST(GridView, GivesSamplesAndNormalsBack) {
  const RangeView view = sphere_view();
  for (const auto& camera : {std::optional<Camera>(), std::optional(kCamera)}) {
    const auto found = value_of(view_from_grid(grid_of(view), camera));
    EXPECT_EQ(found.camera.model(), Camera::Model::kPinhole);
    EXPECT_EQ(found.sample_count(), view.sample_count());
    EXPECT_NEAR((found.point(24, 18) - view.point(24, 18)).norm(), 0.0, 1e-9);
    EXPECT_EQ(found.normals(24, 18), view.normals(24, 18));
    EXPECT_EQ(found.pose, PoseKind::kAbsent);
  }
}

TEST(GridView, LeavesOutNormalsThatCannotBeMeasured) {
  GridFile grid = grid_of(sphere_view());
  grid.normals(24, 18) *= -1.0f;
  grid.normals(25, 18) *= 1.2f;
  grid.normals(26, 18).setZero();
  const auto view = value_of(view_from_grid(grid));
  EXPECT_FALSE(view.has_normal(24, 18));
  EXPECT_NEAR(view.normals(25, 18).norm(), 1.0f, 1e-6f);
  EXPECT_FALSE(view.has_normal(26, 18));
}

TEST(GridView, NamesWhatIsNoGrid) {
  GridFile grid = grid_of(sphere_view());
  EXPECT_THAT(view_from_grid(grid, Camera::pinhole(4, 3, {1, 1, 0, 0})), HasError("camera is 4x3"));
  grid.normals = Grid<Eigen::Vector3f>(2, 2);
  EXPECT_THAT(view_from_grid(grid), HasError("normals is 2x2"));
  EXPECT_THAT(view_from_grid({}), HasError("no points"));
  grid = {};
  grid.points = Grid<Eigen::Vector3d>(9, 1, Eigen::Vector3d::Zero());
  EXPECT_THAT(view_from_grid(grid), HasError("not organized"));
  grid.points = Grid<Eigen::Vector3d>(3, 3, Eigen::Vector3d::Constant(kNoSample));
  EXPECT_THAT(view_from_grid(grid), HasError("finite"));
}

}  // namespace
}  // namespace relief
