#include "fusion/mesh/small_handles.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "fusion/surface/isosurface.h"
#include "relief/scan/mesh_check.h"
#include "tests/fusion/scenes.h"

namespace relief::fusion {
namespace {

constexpr double kVoxel = 0.5;  // Of field_of().

TriangleMesh contour_of(int side, const testing::SignedDistance& distance) {
  return extract_isosurface(testing::field_of(
      side, [&](const Node& node) { return distance(kVoxel * node.cast<double>()); }));
}

// A plate of 12 x 12 x 1.5 with 3 x 3 holes of radius 0.8, four apart, from (4, 4) on.
double sieve(const Eigen::Vector3d& p) {
  const double plate = testing::box_distance({7.0, 7.0, 0.75})(p - Eigen::Vector3d(8.0, 8.0, 8.0));
  const auto nearest = [](double x) { return x - 4.0 * std::clamp(std::round(x / 4.0), 1.0, 3.0); };
  return std::max(plate, 0.8 - std::hypot(nearest(p.x()), nearest(p.y())));
}

TEST(SmallHandles, AreNoneOfABall) {
  const TriangleMesh ball = contour_of(
      4, [](const Eigen::Vector3d& p) { return (p.array() - 8.0).matrix().norm() - 5.0; });
  for (const double side : {2.0, 4.0, 100.0}) EXPECT_EQ(find_small_handles(ball, side).count, 0u);
}

TEST(SmallHandles, AreAllThatThereAreInOneCube) {
  const SmallHandles found = find_small_handles(testing::torus_mesh(), 1000.0);
  EXPECT_EQ(found.count, 1u);
  EXPECT_DOUBLE_EQ(found.area_fraction, 1.0);
  EXPECT_EQ(found.in_region, 1u);
  EXPECT_EQ(find_small_handles(testing::torus_mesh(), 10.0).count, 0u) << "it is a large one";
}

TEST(SmallHandles, OfASieveAreWhereItsHolesAre) {
  const TriangleMesh mesh = contour_of(4, sieve);
  ASSERT_EQ(check_mesh(mesh).genus, 9);
  // Cubes begin at the corner of the plate, (1, 1): one of four voxels has one hole of nine.
  EXPECT_EQ(find_small_handles(mesh, 14.5).count, 9u);
  const SmallHandles small = find_small_handles(mesh, 5.0);
  EXPECT_GE(small.count, 1u);
  EXPECT_LE(small.count, 9u);
  EXPECT_LE(small.in_region, small.count);
  EXPECT_GT(small.area_fraction, 0.02);
  EXPECT_LT(small.area_fraction, 1.0);
  EXPECT_TRUE(bounding_box(mesh).intersects(small.region));
}

}  // namespace
}  // namespace relief::fusion
