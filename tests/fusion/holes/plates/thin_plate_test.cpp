// Plates whose rest is known.

#include "fusion/holes/plates/thin_plate.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

#include <gtest/gtest.h>

namespace relief::fusion {
namespace {

constexpr int kSide = 21;

// A square grid of vertices, jittered in the plane, at a height that is a function of the place.
TriangleMesh sheet(const std::function<double(double, double)>& height, int side = kSide) {
  TriangleMesh mesh;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double px = x + 0.3 * std::sin(5.0 * x + 3.0 * y), py = y + 0.3 * std::cos(7.0 * x - y);
      mesh.vertices.emplace_back(px, py, height(px, py));
    }
  }
  const auto row = static_cast<std::uint32_t>(side);
  for (int y = 0; y + 1 < side; ++y) {
    for (int x = 0; x + 1 < side; ++x) {
      const auto v = static_cast<std::uint32_t>(y * side + x);
      mesh.faces.push_back({v, v + 1, v + row + 1});
      mesh.faces.push_back({v, v + row + 1, v + row});
    }
  }
  return mesh;
}

// Steps of a vertex from the rim of the sheet.
int from_rim(std::uint32_t v, int side) {
  const int x = static_cast<int>(v) % side, y = static_cast<int>(v) / side;
  return std::min(std::min(x, y), std::min(side - 1 - x, side - 1 - y));
}

// The vertices at least `held` + 1 steps from the rim free, those at `held` steps as a support.
PlatePatch patch_of(const TriangleMesh& mesh, int held, double stiffness, double attraction,
                    int side = kSide) {
  PlatePatch patch;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (from_rim(v, side) > held) patch.free.push_back({v, mesh.vertices[v], 1.0, attraction});
    if (from_rim(v, side) == held) patch.held.push_back({v, mesh.vertices[v], stiffness, 0.0});
  }
  return patch;
}

FacesAround all_faces(const TriangleMesh& mesh) {
  return {mesh, std::vector<std::uint8_t>(mesh.vertices.size(), 1)};
}

// A bump that is gone, with its slope, two steps from the rim.
double bump(double x, double y) {
  const double r = std::hypot(x - 10.0, y - 10.0) / 6.0;
  return r < 1.0 ? 2.0 * std::pow(1.0 - r * r, 3) : 0.0;
}

TEST(ThinPlate, APlaneComesToRestAsItIs) {
  const TriangleMesh mesh = sheet([](double x, double y) { return 0.5 * x - 0.2 * y + 3.0; });
  const PlatePatch patch = patch_of(mesh, 3, 1.0, 0.0);
  const auto places = solve_thin_plate(mesh, all_faces(mesh), patch);
  ASSERT_EQ(places.size(), patch.free.size());
  for (std::size_t k = 0; k < places.size(); ++k)
    EXPECT_LT((places[k] - mesh.vertices[patch.free[k].vertex]).norm(), 1e-8);
}

// Of so many vertices that their system is factorised in dense blocks. Errors grow with the fourth
// power of the side.
TEST(ThinPlate, ALargePlaneComesToRestAsItIs) {
  constexpr int kLargeSide = 330;
  const TriangleMesh mesh =
      sheet([](double x, double y) { return 0.5 * x - 0.2 * y + 3.0; }, kLargeSide);
  const PlatePatch patch = patch_of(mesh, 3, 1.0, 0.0, kLargeSide);
  ASSERT_GT(patch.free.size(), 100000u);
  const auto places = solve_thin_plate(mesh, all_faces(mesh), patch);
  ASSERT_EQ(places.size(), patch.free.size());
  double farthest = 0.0;
  for (std::size_t k = 0; k < places.size(); ++k)
    farthest = std::max(farthest, (places[k] - mesh.vertices[patch.free[k].vertex]).norm());
  EXPECT_LT(farthest, 1e-4);
}

TEST(ThinPlate, ADentInAPlaneGoesFlat) {
  const TriangleMesh mesh = sheet(bump);
  for (const double stiffness : {0.0, 1.0}) {
    const PlatePatch patch = patch_of(mesh, 2, stiffness, 0.0);
    const auto places = solve_thin_plate(mesh, all_faces(mesh), patch);
    ASSERT_EQ(places.size(), patch.free.size());
    for (const Eigen::Vector3d& place : places) EXPECT_NEAR(place.z(), 0.0, 1e-7);
  }
}

// A paraboloid is biharmonic: with the slope at its rim a plate finds it again, with a hinge there
// it spans the rim flatter.
TEST(ThinPlate, TheSlopeAtTheRimGoesOn) {
  const auto bowl = [](double x, double y) {
    return 0.01 * (std::pow(x - 10.0, 2) + std::pow(y - 10.0, 2));
  };
  const TriangleMesh mesh = sheet([&](double x, double y) { return bowl(x, y) + bump(x, y); });
  const auto middle = [&](double stiffness) {
    const PlatePatch patch = patch_of(mesh, 3, stiffness, 0.0);
    const auto places = solve_thin_plate(mesh, all_faces(mesh), patch);
    for (std::size_t k = 0; k < places.size(); ++k)
      if (patch.free[k].vertex == kSide * kSide / 2) return places[k].z();
    return -1.0;
  };
  EXPECT_NEAR(middle(1.0), 0.0, 0.1);
  EXPECT_GT(middle(0.0), 0.3);
}

TEST(ThinPlate, APullHoldsVerticesWhereTheyAre) {
  const TriangleMesh mesh = sheet(bump);
  const auto height = [&](double attraction) {
    double most = 0.0;
    for (const auto& place :
         solve_thin_plate(mesh, all_faces(mesh), patch_of(mesh, 2, 1.0, attraction)))
      most = std::max(most, place.z());
    return most;
  };
  EXPECT_NEAR(height(1e4), 2.0, 0.1);
  EXPECT_LT(height(1e-6), 0.1);
}

TEST(ThinPlate, APatchWithoutFreeVerticesHasNoPlaces) {
  const TriangleMesh mesh = sheet(bump);
  PlatePatch patch;
  EXPECT_TRUE(solve_thin_plate(mesh, all_faces(mesh), patch).empty()) << "nothing to place";
}

}  // namespace
}  // namespace relief::fusion
