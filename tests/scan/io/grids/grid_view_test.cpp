#include "scan/io/grids/grid_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/synthetic_views.h"

namespace relief {
namespace {

using ::testing::HasSubstr;

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
    const auto found = view_from_grid(grid_of(view), camera);
    ASSERT_TRUE(found.ok()) << found.error().message;
    EXPECT_EQ(found->camera.model(), Camera::Model::kPinhole);
    EXPECT_EQ(found->sample_count(), view.sample_count());
    EXPECT_NEAR((found->point(24, 18) - view.point(24, 18)).norm(), 0.0, 1e-9);
    EXPECT_EQ(found->normals(24, 18), view.normals(24, 18));
    EXPECT_EQ(found->pose, PoseKind::kAbsent);
  }
}

TEST(GridView, LeavesOutNormalsThatCannotBeMeasured) {
  GridFile grid = grid_of(sphere_view());
  grid.normals(24, 18) *= -1.0f;
  grid.normals(25, 18) *= 1.2f;
  grid.normals(26, 18).setZero();
  const auto view = view_from_grid(grid);
  ASSERT_TRUE(view.ok()) << view.error().message;
  EXPECT_FALSE(view->has_normal(24, 18));
  EXPECT_NEAR(view->normals(25, 18).norm(), 1.0f, 1e-6f);
  EXPECT_FALSE(view->has_normal(26, 18));
}

std::string error_of(const GridFile& grid, const std::optional<Camera>& camera = {}) {
  const auto view = view_from_grid(grid, camera);
  return view.ok() ? "no error" : view.error().message;
}

TEST(GridView, NamesWhatIsNoGrid) {
  GridFile grid = grid_of(sphere_view());
  EXPECT_THAT(error_of(grid, Camera::pinhole(4, 3, {1, 1, 0, 0})), HasSubstr("camera is 4x3"));
  grid.normals = Grid<Eigen::Vector3f>(2, 2);
  EXPECT_THAT(error_of(grid), HasSubstr("normals is 2x2"));
  EXPECT_THAT(error_of({}), HasSubstr("no points"));
  grid = {};
  grid.points = Grid<Eigen::Vector3d>(9, 1, Eigen::Vector3d::Zero());
  EXPECT_THAT(error_of(grid), HasSubstr("not organized"));
  grid.points = Grid<Eigen::Vector3d>(3, 3, Eigen::Vector3d::Constant(kNoSample));
  EXPECT_THAT(error_of(grid), HasSubstr("finite"));
}

}  // namespace
}  // namespace relief
