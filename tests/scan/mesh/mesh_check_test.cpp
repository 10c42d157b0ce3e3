#include "relief/scan/mesh_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "scan/mesh/mesh_components.h"
#include "scan/simulation/objects/geodesic_sphere.h"

namespace relief {
namespace {

TriangleMesh tetrahedron(const Eigen::Vector3d& at = Eigen::Vector3d::Zero()) {
  TriangleMesh mesh;
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0),
                                   Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)})
    mesh.vertices.push_back(at + p);
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return mesh;
}

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh = a;
  const auto offset = static_cast<std::uint32_t>(a.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& f : b.faces) mesh.faces.push_back({f[0] + offset, f[1] + offset, f[2] + offset});
  return mesh;
}

void rename(TriangleMesh& mesh, std::uint32_t from, std::uint32_t to) {
  for (auto& face : mesh.faces) std::replace(face.begin(), face.end(), from, to);
}

// A torus of n x m quads.
TriangleMesh torus(std::uint32_t n, std::uint32_t m) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < m; ++j) {
      const double a = 2.0 * M_PI * i / n, b = 2.0 * M_PI * j / m, r = 3.0 + std::cos(b);
      mesh.vertices.emplace_back(r * std::cos(a), r * std::sin(a), std::sin(b));
      const auto at = [&](std::uint32_t di, std::uint32_t dj) {
        return (i + di) % n * m + (j + dj) % m;
      };
      mesh.faces.push_back({at(0, 0), at(1, 0), at(1, 1)});
      mesh.faces.push_back({at(0, 0), at(1, 1), at(0, 1)});
    }
  }
  return mesh;
}

TEST(MeshCheck, ATetrahedronIsWatertight) {
  const MeshCheck check = check_mesh(tetrahedron());
  EXPECT_TRUE(check.watertight());
  EXPECT_EQ(check.edges, 6u);
  EXPECT_EQ(check.components, 1u);
  EXPECT_EQ(check.genus, 0);
  EXPECT_NEAR(check.volume, 1.0 / 6.0, 1e-15);
}

TEST(MeshCheck, CountsHandlesAndComponents) {
  TriangleMesh mesh = torus(20, 10);
  EXPECT_EQ(check_mesh(mesh).genus, 1);
  EXPECT_TRUE(check_mesh(mesh).watertight());
  mesh = joined(mesh, tetrahedron({10, 0, 0}));
  EXPECT_EQ(check_mesh(mesh).components, 2u);
  EXPECT_EQ(check_mesh(mesh).genus, 1);
}

TEST(MeshCheck, AMissingFaceLeavesABoundary) {
  TriangleMesh mesh = tetrahedron();
  mesh.faces.pop_back();
  const MeshCheck check = check_mesh(mesh);
  EXPECT_EQ(check.boundary_edges, 3u);
  EXPECT_FALSE(check.closed());
  EXPECT_TRUE(check.manifold());
  EXPECT_EQ(check.genus, -1);
}

TEST(MeshCheck, AFlippedFaceIsInconsistent) {
  TriangleMesh mesh = tetrahedron();
  std::swap(mesh.faces[0][0], mesh.faces[0][1]);
  EXPECT_EQ(check_mesh(mesh).inconsistent_edges, 3u);
  EXPECT_FALSE(check_mesh(mesh).closed());
}

TEST(MeshCheck, InsideOutHasNegativeVolume) {
  TriangleMesh mesh = tetrahedron();
  for (auto& face : mesh.faces) std::swap(face[0], face[1]);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.closed());
  EXPECT_LT(check.volume, 0.0);
  EXPECT_FALSE(check.watertight());
}

TEST(MeshCheck, TwoSolidsThatTouchInAVertexAreNotManifold) {
  TriangleMesh mesh = joined(tetrahedron(), tetrahedron({-1, 0, 0}));
  rename(mesh, 5, 0);  // (-1,0,0) + (1,0,0) is the first one's corner
  const MeshCheck check = check_mesh(mesh);
  EXPECT_EQ(check.non_manifold_vertices, 1u);
  EXPECT_EQ(check.non_manifold_edges, 0u);
  EXPECT_EQ(check.unused_vertices, 1u);
  EXPECT_EQ(check.components, 1u);
}

TEST(MeshCheck, TwoSolidsThatShareAnEdgeAreNotManifold) {
  TriangleMesh mesh = joined(tetrahedron(), tetrahedron());
  rename(mesh, 4, 0);
  rename(mesh, 5, 1);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_EQ(check.non_manifold_edges, 1u);
  EXPECT_FALSE(check.closed());
}

TEST(MeshCheck, CountsDegenerateFacesAndDuplicateVertices) {
  TriangleMesh mesh = tetrahedron();
  mesh.vertices[3] = {0.5, 0.5, 0.0};  // on the line from 1 to 2
  EXPECT_EQ(check_mesh(mesh).degenerate_faces, 1u);
  mesh.vertices[3] = mesh.vertices[1];
  EXPECT_EQ(check_mesh(mesh).duplicate_vertices, 1u);
  mesh.faces.push_back({0, 0, 1});
  EXPECT_EQ(check_mesh(mesh).degenerate_faces, 3u);
}

// Every count of a check by its name, so that a test can say which ones changed.
std::map<std::string, long> counts_of(const TriangleMesh& mesh) {
  const MeshCheck check = check_mesh(mesh, {.self_intersections = true});
  const auto count = [](std::size_t n) { return static_cast<long>(n); };
  return {{"boundary edges", count(check.boundary_edges)},
          {"non-manifold edges", count(check.non_manifold_edges)},
          {"inconsistent edges", count(check.inconsistent_edges)},
          {"non-manifold vertices", count(check.non_manifold_vertices)},
          {"unused vertices", count(check.unused_vertices)},
          {"degenerate faces", count(check.degenerate_faces)},
          {"duplicate vertices", count(check.duplicate_vertices)},
          {"invalid faces", count(check.invalid_faces)},
          {"non-finite vertices", count(check.non_finite_vertices)},
          {"components", count(check.components)},
          {"self-intersections", count(check.self_intersections->pairs.size())}};
}

// The counts that a fault added to those of a sound sphere.
std::map<std::string, long> added_counts(const TriangleMesh& faulty) {
  std::map<std::string, long> added;
  const auto sound = counts_of(simulation::geodesic_sphere(6));
  for (const auto& [name, count] : counts_of(faulty))
    if (count != sound.at(name)) added[name] = count - sound.at(name);
  return added;
}

using Counts = std::map<std::string, long>;

TEST(MeshCheck, FindsEachFaultAndNothingElse) {
  const TriangleMesh sphere = simulation::geodesic_sphere(6);
  EXPECT_EQ(added_counts(sphere), Counts{});

  TriangleMesh hole = sphere;
  hole.faces.erase(hole.faces.begin() + 100);
  EXPECT_EQ(added_counts(hole), (Counts{{"boundary edges", 3}}));

  TriangleMesh flipped = sphere;
  std::swap(flipped.faces[100][0], flipped.faces[100][1]);
  EXPECT_EQ(added_counts(flipped), (Counts{{"inconsistent edges", 3}}));

  TriangleMesh doubled = sphere;
  doubled.vertices.push_back(doubled.vertices[50]);
  EXPECT_EQ(added_counts(doubled), (Counts{{"duplicate vertices", 1}, {"unused vertices", 1}}));

  // A face that has a corner of its own where its neighbours meet: the two edges there open.
  TriangleMesh split = sphere;
  split.vertices.push_back(split.corner(100, 0));
  split.faces[100][0] = static_cast<std::uint32_t>(sphere.vertices.size());
  EXPECT_EQ(added_counts(split), (Counts{{"duplicate vertices", 1}, {"boundary edges", 4}}));

  // Two closed surfaces that touch in a point where each has a vertex.
  TriangleMesh touching = sphere;
  for (auto& vertex : touching.vertices) vertex = 2.0 * sphere.vertices[0] - vertex;
  for (auto& face : touching.faces) std::swap(face[0], face[1]);
  EXPECT_EQ(added_counts(joined(sphere, touching)),
            (Counts{{"duplicate vertices", 1}, {"components", 1}}));
}

TEST(MeshCheck, FindsASelfIntersectionAndNothingElse) {
  const TriangleMesh sphere = simulation::geodesic_sphere(6);
  // A slender spike from inside through the middle of face 100.
  TriangleMesh spike = tetrahedron();
  const Eigen::Vector3d middle =
      (sphere.corner(100, 0) + sphere.corner(100, 1) + sphere.corner(100, 2)) / 3.0;
  for (auto& vertex : spike.vertices) vertex = 0.5 * middle + 1e-3 * vertex;
  spike.vertices[3] = 1.5 * middle;
  const MeshCheck check = check_mesh(joined(sphere, spike), {.self_intersections = true});
  EXPECT_EQ(check.self_intersections->pairs.size(), 3u);  // face 100 with each side of the spike
  for (const auto& [f, g] : check.self_intersections->pairs) {
    EXPECT_EQ(f, 100u);
    EXPECT_GE(g, sphere.faces.size());
  }
  EXPECT_EQ(added_counts(joined(sphere, spike)),
            (Counts{{"self-intersections", 3}, {"components", 1}}));
}

TEST(MeshCheck, LooksForSelfIntersectionsOnlyWhenAsked) {
  EXPECT_FALSE(check_mesh(tetrahedron()).self_intersections);
}

TEST(MeshCheck, SurvivesNonsense) {
  EXPECT_FALSE(check_mesh({}).watertight());
  TriangleMesh mesh = tetrahedron();
  mesh.faces.push_back({0, 1, 77});
  EXPECT_EQ(check_mesh(mesh).invalid_faces, 1u);
  EXPECT_FALSE(check_mesh(mesh).watertight());
  mesh = tetrahedron();
  mesh.vertices[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(check_mesh(mesh).non_finite_vertices, 1u);
  EXPECT_FALSE(check_mesh(mesh).watertight());
}

TEST(MeshCheck, OfMovedVerticesIsThatOfTheMesh) {
  TriangleMesh mesh = torus(30, 20);
  const MeshCheck before = check_mesh(mesh, {.self_intersections = true});
  mesh.vertices[5] = mesh.vertices[6];  // No area between them.
  mesh.vertices[70].z() = std::numeric_limits<double>::infinity();
  const MeshCheck whole = check_mesh(mesh), moved = check_moved_vertices(mesh, before);
  EXPECT_EQ(moved.duplicate_vertices, 1u);
  EXPECT_EQ(moved.degenerate_faces, whole.degenerate_faces);
  EXPECT_GT(moved.degenerate_faces, 1u);
  EXPECT_EQ(moved.non_finite_vertices, 1u);
  EXPECT_EQ(moved.genus, whole.genus);
  EXPECT_FALSE(moved.self_intersections);
  mesh.vertices[70] = mesh.vertices[5] = {0, 0, 9};
  EXPECT_EQ(check_moved_vertices(mesh, before).volume, check_mesh(mesh).volume);
  mesh.faces.pop_back();
  EXPECT_EQ(check_moved_vertices(mesh, before).boundary_edges, 3u);  // Other faces: all anew.
}

// So many that they are sorted in parts. Zeros of both signs are one place.
TEST(MeshCheck, CountsRepeatedPlacesOfManyVertices) {
  TriangleMesh mesh;
  for (int i = 0; i < 200000; ++i) mesh.vertices.emplace_back(i % 500, i / 500, 0.0);
  EXPECT_EQ(check_mesh(mesh).duplicate_vertices, 0u);
  for (int i = 0; i < 1000; ++i) mesh.vertices.emplace_back((7 * i) % 500, i / 3, -0.0);
  EXPECT_EQ(check_mesh(mesh).duplicate_vertices, 1000u);
}

// All arrays lie in files, and each look at the memory evicts them.
TEST(MeshCheck, IsTheSameWithinAMemoryLimit) {
  const TriangleMesh mesh = torus(300, 200);
  const MeshCheckOptions options{.self_intersections = true};
  const MeshCheck free = check_mesh(mesh, options);
  run_until_stopped({.memory = 1}, [&] {
    const TriangleMesh paged = mesh;
    const MeshCheck check = check_mesh(paged, options);
    EXPECT_EQ(check.edges, free.edges);
    EXPECT_EQ(check.volume, free.volume);
    EXPECT_TRUE(check.watertight());
    EXPECT_TRUE(check.self_intersections->pairs.empty());
    EXPECT_EQ(vertex_normals(paged), vertex_normals(mesh));
  });
}

TEST(MeshComponents, TheLargestIsKeptWithItsAttributes) {
  TriangleMesh mesh = joined(tetrahedron({5, 0, 0}), torus(8, 6));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.quality.push_back(static_cast<float>(v));
  const double all = surface_area(mesh);
  const RemovedComponents removed = keep_largest_component(mesh);
  EXPECT_EQ(removed.components, 1u);
  EXPECT_NEAR(removed.area_fraction, 1.0 - surface_area(mesh) / all, 1e-12);
  EXPECT_EQ(removed.faces, 4u);
  EXPECT_EQ(mesh.vertices.size(), 48u);
  EXPECT_EQ(mesh.quality.front(), 4.0f);
  EXPECT_TRUE(check_mesh(mesh).watertight());
}

TEST(MeshComponents, NothingHappensToAnEmptyMesh) {
  TriangleMesh mesh;
  EXPECT_EQ(keep_largest_component(mesh).components, 0u);
  EXPECT_TRUE(mesh.vertices.empty());
}

}  // namespace
}  // namespace relief
