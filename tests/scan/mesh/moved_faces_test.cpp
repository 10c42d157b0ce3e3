#include "scan/mesh/moved_faces.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

#include <gtest/gtest.h>

#include "relief/scan/mesh_check.h"

namespace relief {
namespace {

// A sheet of two rows of quads, and one above it.
TriangleMesh two_sheets(double distance) {
  TriangleMesh mesh;
  for (const double z : {0.0, distance}) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 9; ++x) mesh.vertices.emplace_back(x, y, z);
    for (std::uint32_t y = 0; y < 2; ++y) {
      for (std::uint32_t x = 0; x < 8; ++x) {
        const std::uint32_t v = first + 9 * y + x;
        mesh.faces.push_back({v, v + 1, v + 10});
        mesh.faces.push_back({v, v + 10, v + 9});
      }
    }
  }
  return mesh;
}

TEST(MovedFaces, FindsFacesThatCrossOthers) {
  const TriangleMesh mesh = two_sheets(1.0);
  PagedVector<Eigen::Vector3d> places = mesh.vertices;
  std::vector<std::uint8_t> moved(places.size(), 0);
  moved[13] = 1;
  EXPECT_TRUE(invalid_faces(mesh, places, moved, 1.0).empty());
  places[13].z() = 1.5;
  const auto spoiled = invalid_faces(mesh, places, moved, 1.0);
  ASSERT_FALSE(spoiled.empty());
  TriangleMesh after = mesh;
  after.vertices = places;
  EXPECT_EQ(spoiled, find_self_intersections(after).faces()) << "with those of the sheet above";
  moved[13] = 0;
  moved[9] = 1;
  EXPECT_TRUE(invalid_faces(mesh, places, moved, 1.0).empty()) << "far away";
}

TEST(MovedFaces, ManyFacesAreSearchedAsFewAre) {
  TriangleMesh mesh = two_sheets(1.0);
  mesh.vertices[13].z() = 1.5;
  const auto all = find_self_intersections(mesh).faces();
  ASSERT_FALSE(all.empty());
  const PagedVector<std::uint32_t> few{all.front()};
  EXPECT_EQ(intersecting_faces(mesh, few, 1.0), all);
  PagedVector<std::uint32_t> many(mesh.faces.size());
  std::iota(many.begin(), many.end(), 0u);
  EXPECT_EQ(intersecting_faces(mesh, many, 1.0), all);
}

// Its box has 10^12 places of the size of an edge.
TEST(MovedFaces, AFaceMayBeStretchedFar) {
  const TriangleMesh mesh = two_sheets(1.0);
  PagedVector<Eigen::Vector3d> places = mesh.vertices;
  std::vector<std::uint8_t> moved(places.size(), 0);
  moved[13] = 1;
  places[13] = Eigen::Vector3d(1e4, 1e4, 1e4);
  TriangleMesh after = mesh;
  after.vertices = places;
  EXPECT_EQ(invalid_faces(mesh, places, moved, 1.0), find_self_intersections(after).faces());
}

TEST(MovedFaces, FindsFacesWithoutWidth) {
  const TriangleMesh mesh = two_sheets(1.0);
  PagedVector<Eigen::Vector3d> places = mesh.vertices;
  std::vector<std::uint8_t> moved(places.size(), 0);
  moved[1] = 1;
  places[1] = Eigen::Vector3d(0.5, 0.5 + 1e-9, 0.0);  // on the diagonal of the first quad
  const auto spoiled = invalid_faces(mesh, places, moved, 1.0);
  EXPECT_TRUE(std::binary_search(spoiled.begin(), spoiled.end(), 0u));
}

}  // namespace
}  // namespace relief
