#include "fusion/mesh/crease_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "fusion/surface/isosurface.h"
#include "relief/scan/context.h"
#include "relief/scan/mesh_check.h"
#include "tests/fusion/scenes.h"

namespace relief::fusion {
namespace {

using testing::box_distance;
using testing::field_of;
using testing::SignedDistance;

constexpr double kVoxel = 0.5;
constexpr CreaseEdgeOptions kOptions{kVoxel, 0.0};

// A box that lies askew in its lattice, as a distance in the frame of the mesh.
SignedDistance tilted_box() {
  const SignedDistance box = box_distance({3.6, 3.1, 2.7});
  const Eigen::Quaterniond turn(0.8, 0.25, -0.4, 0.36);
  return [=](const Eigen::Vector3d& p) {
    return box(turn.normalized().conjugate() * (p - Eigen::Vector3d(7.03, 8.01, 8.96)));
  };
}

TriangleMesh contour_of(const SignedDistance& distance) {
  const SparseField field = field_of(3, [&](const Node& node) {
    return distance(Eigen::Vector3d(1, 2, 3) + kVoxel * node.cast<double>());
  });
  return extract_isosurface(field);
}

// Root of the mean squared distance of the faces' points from the shape [voxels].
double rms_of_faces(const TriangleMesh& mesh, const SignedDistance& distance) {
  double squares = 0.0, area = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const double size = face_cross(mesh, f).norm();
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d middle = 0.5 * (mesh.corner(f, k) + mesh.corner(f, (k + 1) % 3));
      squares += size / 3.0 * std::pow(distance(middle) / kVoxel, 2);
    }
    area += size;
  }
  return std::sqrt(squares / area);
}

double thinnest(const TriangleMesh& mesh) {
  double least = 1.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    double longest = 0.0;
    for (int k = 0; k < 3; ++k)
      longest = std::max(longest, (mesh.corner(f, (k + 1) % 3) - mesh.corner(f, k)).squaredNorm());
    least = std::min(least, face_cross(mesh, f).norm() / longest);
  }
  return least;
}

TEST(CreaseEdges, RunAlongTheEdgesOfABox) {
  const SignedDistance box = tilted_box();
  const TriangleMesh contour = contour_of(box);
  TriangleMesh mesh = contour;
  EXPECT_GT(align_edges_with_creases(mesh, kOptions), 50u);
  EXPECT_LT(rms_of_faces(mesh, box), 0.8 * rms_of_faces(contour, box));
  EXPECT_EQ(mesh.vertices, contour.vertices);
  MeshCheckOptions thorough;
  thorough.self_intersections = true;
  const MeshCheck check = check_mesh(mesh, thorough);
  EXPECT_TRUE(check.watertight());
  EXPECT_EQ(check.genus, 0);
  EXPECT_TRUE(check.self_intersections->pairs.empty());
  EXPECT_GE(thinnest(mesh), std::min(thinnest(contour), 0.1));
}

TEST(CreaseEdges, AreTheSameOnAnyNumberOfThreads) {
  TriangleMesh one = contour_of(tilted_box()), four = one;
  const auto align_on = [](int threads, TriangleMesh& mesh) {
    return on_threads(threads, [&] { return align_edges_with_creases(mesh, {kVoxel, 0.0}); });
  };
  EXPECT_EQ(align_on(1, one), align_on(4, four));
  EXPECT_EQ(one.faces, four.faces);
  EXPECT_EQ(one.normals, four.normals);
}

TEST(CreaseEdges, ComeToRest) {
  TriangleMesh mesh = contour_of(tilted_box());
  const std::size_t turned = align_edges_with_creases(mesh, kOptions);
  EXPECT_LT(align_edges_with_creases(mesh, kOptions), turned / 10);
}

TEST(CreaseEdges, KeepASmoothSurfaceAsGood) {
  const auto sphere = [](const Eigen::Vector3d& p) {
    return (p - Eigen::Vector3d(7.03, 8.01, 8.96)).norm() - 4.2;
  };
  TriangleMesh mesh = contour_of(sphere);
  const double before = rms_of_faces(mesh, sphere);
  align_edges_with_creases(mesh, kOptions);
  EXPECT_LT(rms_of_faces(mesh, sphere), 1.01 * before);
}

// Surfaces without any shape, with many handles, vertices of three faces and slivers.
TEST(CreaseEdges, LeaveAClosedManifoldWhateverItsShape) {
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    std::mt19937 random(seed);
    const SparseField field = field_of(
        3, [&](const Node&) { return static_cast<double>(random() % 2001) / 1000.0 - 1.0; });
    TriangleMesh mesh = extract_isosurface(field);
    const MeshCheck before = check_mesh(mesh);
    align_edges_with_creases(mesh, kOptions);
    MeshCheckOptions thorough;
    thorough.self_intersections = true;
    const MeshCheck after = check_mesh(mesh, thorough);
    EXPECT_TRUE(after.closed() && after.manifold()) << seed;
    EXPECT_EQ(after.degenerate_faces, 0u) << seed;
    EXPECT_EQ(after.genus, before.genus) << seed;
    EXPECT_TRUE(after.self_intersections->pairs.empty()) << seed;
  }
}

TEST(CreaseEdges, OfNothingAreNone) {
  TriangleMesh mesh;
  EXPECT_EQ(align_edges_with_creases(mesh, kOptions), 0u);
}

}  // namespace
}  // namespace relief::fusion
