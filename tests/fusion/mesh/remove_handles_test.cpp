#include "fusion/mesh/remove_handles.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "fusion/mesh/cube_patches.h"
#include "fusion/mesh/handle_loops.h"
#include "fusion/surface/isosurface.h"
#include "relief/scan/mesh_check.h"
#include "tests/fusion/scenes.h"

namespace relief::fusion {
namespace {

constexpr double kVoxel = 0.5;                 // Of field_of(),
const Eigen::Vector3d kOrigin(1.0, 2.0, 3.0);  // and the place of its first node.
constexpr double kRadius = 0.8, kApart = 4.0;

double plate_distance(const Eigen::Vector3d& p) {
  return testing::box_distance({7.0, 7.0, 0.75})(p - Eigen::Vector3d(8.0, 8.0, 8.0));
}

double to_nearest_axis(const Eigen::Vector3d& p) {
  const auto nearest = [](double x) {
    return x - kApart * std::clamp(std::round(x / kApart), 1.0, 3.0);
  };
  return std::hypot(nearest(p.x()), nearest(p.y()));
}

// A plate of 14 x 14 x 1.5 with 3 x 3 holes. No view measured any of it.
TriangleMesh sieve() {
  TriangleMesh mesh = extract_isosurface(testing::field_of(4, [](const Node& node) {
    const Eigen::Vector3d p = kVoxel * node.cast<double>();
    return std::max(plate_distance(p), kRadius - to_nearest_axis(p));
  }));
  mesh.filled.assign(mesh.vertices.size(), 1);
  return mesh;
}

HandleRemovalOptions options(double side) {
  return {side, kVoxel, [] { return [](const Eigen::Vector3d&) { return false; }; }};
}

bool any(const HandleLoop&) { return true; }

TEST(HandleLoops, OfASieveRunRoundItsHolesOrBetweenThem) {
  const TriangleMesh mesh = sieve();
  const auto patches = CubePatches(mesh, 14.5).faces_with_handles();
  ASSERT_EQ(patches.size(), 1u);
  const auto loop = short_handle_loop(mesh, patches[0], mesh.filled, any);
  ASSERT_TRUE(loop);
  EXPECT_NEAR(loop->length, 2.0 * M_PI * kRadius, 1.0);
  for (const std::uint32_t v : loop->vertices)
    EXPECT_NEAR(to_nearest_axis(mesh.vertices[v] - kOrigin), kRadius, kVoxel);
  const auto longer = short_handle_loop(mesh, patches[0], mesh.filled,
                                        [](const HandleLoop& other) { return other.length > 7.0; });
  ASSERT_TRUE(longer);
  auto once = longer->vertices;
  std::ranges::sort(once);
  EXPECT_EQ(std::ranges::adjacent_find(once), once.end()) << "each vertex once";
}

TEST(HandleLoops, AreNoneOfASphere) {
  const TriangleMesh ball = extract_isosurface(testing::field_of(4, [](const Node& node) {
    return (kVoxel * node.cast<double>().array() - 8.0).matrix().norm() - 5.0;
  }));
  EXPECT_TRUE(CubePatches(ball, 100.0).faces_with_handles().empty());
  const std::vector<std::uint8_t> all(ball.vertices.size(), 1);
  std::vector<std::uint32_t> faces(ball.faces.size());
  std::iota(faces.begin(), faces.end(), 0u);
  EXPECT_FALSE(short_handle_loop(ball, faces, all, any));
}

TEST(RemoveHandles, ClosesTheHolesOfASieve) {
  TriangleMesh mesh = sieve();
  const double before = enclosed_volume(mesh);
  const std::size_t removed = remove_unmeasured_handles(mesh, options(6.0));
  EXPECT_GE(removed, 4u);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.watertight());
  EXPECT_EQ(check.genus, 9 - static_cast<long>(removed));
  EXPECT_EQ(check.components, 1u);
  EXPECT_TRUE(find_self_intersections(mesh, {}).faces().empty());
  EXPECT_EQ(mesh.filled.size(), mesh.vertices.size());
  EXPECT_GT(enclosed_volume(mesh), before) << "closed, not cut open";
}

TEST(RemoveHandles, LeavesLargeOnesAndThoseThatViewsMeasuredOrSawThrough) {
  TriangleMesh mesh = sieve();
  EXPECT_EQ(remove_unmeasured_handles(mesh, options(1.0)), 0u) << "they are larger";
  auto seen_through = options(6.0);
  seen_through.emptiness = [] { return [](const Eigen::Vector3d&) { return true; }; };
  EXPECT_EQ(remove_unmeasured_handles(mesh, seen_through), 0u);
  mesh.filled.assign(mesh.vertices.size(), 0);
  EXPECT_EQ(remove_unmeasured_handles(mesh, options(6.0)), 0u);
  const TriangleMesh as_given = sieve();
  EXPECT_EQ(mesh.vertices, as_given.vertices);
  EXPECT_EQ(mesh.faces, as_given.faces);
}

// Two plates a voxel apart, with a pillar between them in a corner: a membrane across it would lie
// within both.
TEST(RemoveHandles, LeavesTheSurfaceWithoutIntersections) {
  TriangleMesh mesh = extract_isosurface(testing::field_of(4, [](const Node& node) {
    const Eigen::Vector3d p = kVoxel * node.cast<double>();
    const auto box = [&](double x, double y, double z, const Eigen::Vector3d& half) {
      return testing::box_distance(half)(p - Eigen::Vector3d(x, y, z));
    };
    const double plates =
        std::min(box(8.0, 8.0, 6.7, {5.0, 5.0, 0.8}), box(8.0, 8.0, 8.9, {5.0, 5.0, 0.8}));
    double pillars = 100.0;
    for (int i = 0; i < 5; ++i)
      pillars = std::min(pillars, box(5.0 + 1.5 * i, 8.0, 7.8, {0.4, 0.4, 1.0}));
    return std::min(plates, pillars);
  }));
  mesh.filled.assign(mesh.vertices.size(), 1);
  const long genus = check_mesh(mesh).genus;
  ASSERT_EQ(genus, 4);
  const std::size_t removed = remove_unmeasured_handles(mesh, options(4.0));
  EXPECT_GE(removed, 1u);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.watertight());
  EXPECT_EQ(check.genus, genus - static_cast<long>(removed));
  EXPECT_TRUE(find_self_intersections(mesh, {}).faces().empty());
}

}  // namespace
}  // namespace relief::fusion
