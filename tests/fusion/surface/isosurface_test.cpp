#include "fusion/surface/isosurface.h"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "relief/scan/mesh_check.h"
#include "tests/fusion/scenes.h"

namespace relief::fusion {
namespace {

using testing::field_of;

TEST(Isosurface, OfADistanceIsTheSphere) {
  const Eigen::Vector3d centre(12.2, 11.9, 12.4);
  const SparseField field =
      field_of(3, [&](const Node& n) { return (n.cast<double>() - centre).norm() - 7.7; });
  const TriangleMesh mesh = extract_isosurface(field);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.watertight());
  EXPECT_EQ(check.genus, 0);
  EXPECT_EQ(check.components, 1u);
  for (const auto& p : mesh.vertices)
    EXPECT_NEAR((field.lattice().coordinates(p) - centre).norm(), 7.7, 0.03);
}

void expect_closed_manifold(const TriangleMesh& mesh, const std::string& what) {
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.closed()) << what;
  EXPECT_TRUE(check.manifold()) << what;
  EXPECT_EQ(check.degenerate_faces, 0u) << what;
  EXPECT_EQ(check.duplicate_vertices, 0u) << what;
  EXPECT_GT(check.volume, 0.0) << what;
}

// Two neighbouring cells could both triangulate their polygons with the same diagonal of their
// common face, and four triangles would share that edge. The contour filter's case table never
// does: here are all the signs that the twelve nodes of two neighbouring cells can have.
TEST(Isosurface, IsManifoldWhateverTheSignsInTwoNeighbouringCells) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int signs = 1; signs < 4096 && !::testing::Test::HasFailure(); ++signs) {
      const SparseField field = field_of(1, [&](const Node& n) {
        const int along = n[axis] - 2, beside = n[(axis + 1) % 3] - 3,
                  above = n[(axis + 2) % 3] - 3;
        const bool among =
            along >= 0 && along < 3 && beside >= 0 && beside < 2 && above >= 0 && above < 2;
        return among && (signs >> (along + 3 * beside + 6 * above) & 1) ? -1.0 : 1.0;
      });
      expect_closed_manifold(extract_isosurface(field),
                             "signs " + std::to_string(signs) + ", axis " + std::to_string(axis));
    }
  }
}

TEST(Isosurface, OfRandomValuesIsAClosedManifold) {
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    std::mt19937 random(seed);
    const SparseField field = field_of(3, [&](const Node&) {
      return static_cast<double>(random() % 2001) / 1000.0 - 1.0 + 0.1 * (seed % 5);
    });
    expect_closed_manifold(extract_isosurface(field), "seed " + std::to_string(seed));
  }
}

TEST(Isosurface, ThroughLatticeNodesHasNoDegenerateFaces) {
  const SparseField field = field_of(2, [](const Node& n) {
    return static_cast<double>((n - Node(7, 7, 7)).cwiseAbs().sum()) - 4.0;
  });
  EXPECT_TRUE(check_mesh(extract_isosurface(field)).watertight());
}

// Beside a value ten million times as large the zero is nearer to a node than single precision can
// tell from it.
TEST(Isosurface, OfValuesThatDifferBeyondPrecisionIsAClosedManifold) {
  for (const double outside : {1e4, 1e7, 1e10}) {
    const SparseField field = field_of(2, [&](const Node& n) {
      return (n.cast<double>() - Eigen::Vector3d(7.3, 7.1, 7.6)).norm() < 4.2 ? -1.0 : outside;
    });
    const TriangleMesh mesh = extract_isosurface(field);
    const MeshCheck check = check_mesh(mesh);
    EXPECT_TRUE(check.closed()) << outside;
    EXPECT_TRUE(check.manifold()) << outside;
    EXPECT_GT(check.volume, 0.0) << outside;
    for (const auto& p : mesh.vertices)
      EXPECT_LT((field.lattice().coordinates(p) - Eigen::Vector3d(7.3, 7.1, 7.6)).norm(), 4.21);
  }
}

TEST(Isosurface, ThreadsDoNotChangeAByte) {
  std::mt19937 random(3);
  const SparseField field =
      field_of(4, [&](const Node&) { return static_cast<double>(random() % 11) - 5.0; });
  const auto extracted_on = [&](int threads) {
    return on_threads(threads, [&] { return extract_isosurface(field); });
  };
  const TriangleMesh a = extracted_on(1), b = extracted_on(4);
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.faces, b.faces);
}

TEST(Isosurface, OfAFieldOfOneSignIsEmpty) {
  const SparseField field = field_of(1, [](const Node&) { return 0.5; });
  EXPECT_TRUE(extract_isosurface(field).faces.empty());
}

}  // namespace
}  // namespace relief::fusion
