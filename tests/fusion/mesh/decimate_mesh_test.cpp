#include "relief/fusion/decimate_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <stop_token>

#include <gtest/gtest.h>

#include "fusion/mesh/decimation/edge_collapse.h"
#include "relief/fusion/merge_views.h"
#include "relief/scan/context.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

double largest_error(const TriangleMesh& mesh) {
  const auto torus = testing::torus_distance(35.0, 12.0);
  double largest = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    largest = std::max(
        largest,
        std::abs(torus((mesh.corner(f, 0) + mesh.corner(f, 1) + mesh.corner(f, 2)) / 3.0)));
  return largest;
}

TEST(DecimateMesh, EndsWhenTheComputationAroundItIsToStop) {
  const TriangleMesh& mesh = testing::torus_mesh();
  std::stop_source source;
  source.request_stop();
  const auto result =
      run_in({.stop = source.get_token()}, [&] { return decimate_mesh(mesh, {.faces = 4000}); });
  EXPECT_THAT(result, HasError(ErrorKind::kInterrupted));
}

TEST(DecimateMesh, ReachesANumberOfFacesAndStaysAClosedTorus) {
  const auto result = value_of(decimate_mesh(testing::torus_mesh(), {.faces = 4000}));
  EXPECT_NEAR(static_cast<double>(result.mesh.faces.size()), 4000.0, 40.0);
  EXPECT_TRUE(result.check.watertight());
  EXPECT_EQ(result.check.genus, 1);
  EXPECT_LT(largest_error(result.mesh), 0.6);
}

TEST(DecimateMesh, ReachesFewFacesOfARoughSurface) {
  TriangleMesh mesh = testing::torus_mesh();
  for (auto& v : mesh.vertices)
    v += 0.4 * std::sin(v.x()) * std::sin(v.y() + 1.0) * std::sin(v.z() + 2.0) *
         Eigen::Vector3d(v.x(), v.y(), 0.0).normalized();
  for (const std::size_t faces : {4000, 1000, 250}) {
    const auto result = value_of(decimate_mesh(mesh, {.faces = faces}));
    EXPECT_LE(result.mesh.faces.size(), faces);
    EXPECT_TRUE(result.check.watertight());
    EXPECT_EQ(result.check.genus, 1);
  }
}

TEST(DecimateMesh, ABoundOfTheErrorIsKept) {
  std::size_t last = testing::torus_mesh().faces.size();
  for (const double bound : {0.02, 0.1, 0.5}) {
    const auto result = value_of(decimate_mesh(testing::torus_mesh(), {.max_error = bound}));
    EXPECT_TRUE(result.check.watertight());
    EXPECT_LT(result.mesh.faces.size(), last);
    EXPECT_LT(largest_error(result.mesh), bound + 0.05) << "and that of merging";
    last = result.mesh.faces.size();
  }
}

TEST(DecimateMesh, TakesAttributesOfAGivenVertexNearby) {
  TriangleMesh mesh = testing::torus_mesh();
  ASSERT_LT(mesh.vertices.size(), 1u << 24) << "so that indices are exact as float";
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) mesh.quality[v] = static_cast<float>(v);
  const auto result = value_of(decimate_mesh(mesh, {.faces = 2000}));
  const TriangleMesh& fewer = result.mesh;
  ASSERT_EQ(fewer.quality.size(), fewer.vertices.size());
  ASSERT_EQ(fewer.filled.size(), fewer.vertices.size());
  ASSERT_EQ(fewer.normals.size(), fewer.vertices.size());
  const double edge = std::sqrt(surface_area(fewer) / static_cast<double>(fewer.faces.size()));
  for (std::size_t v = 0; v < fewer.vertices.size(); ++v) {
    const auto given = static_cast<std::size_t>(fewer.quality[v]);
    EXPECT_LT((fewer.vertices[v] - mesh.vertices[given]).norm(), 3.0 * edge);
    EXPECT_EQ(fewer.filled[v], mesh.filled[given]);
  }
}

double rms_error(const TriangleMesh& mesh) {
  const auto torus = testing::torus_distance(35.0, 12.0);
  double squares = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (const auto& at : {Eigen::Vector3d(1, 1, 1), {4, 1, 1}, {1, 4, 1}, {1, 1, 4}})
      squares += std::pow(torus((at[0] * mesh.corner(f, 0) + at[1] * mesh.corner(f, 1) +
                                 at[2] * mesh.corner(f, 2)) /
                                at.sum()),
                          2);
  return std::sqrt(squares / (4.0 * static_cast<double>(mesh.faces.size())));
}

TEST(DecimateMesh, MovesVerticesToWhereTheyErrLeast) {
  TriangleMesh kept = testing::torus_mesh();
  collapse_edges(kept, {.faces = 1000, .max_error = std::numeric_limits<double>::infinity()});
  const auto moved = value_of(decimate_mesh(testing::torus_mesh(), {.faces = 1000}));
  EXPECT_LT(rms_error(moved.mesh), 0.6 * rms_error(kept));
}

// A grid of quads over each side of a cube. Along its edges the sides share vertices.
TriangleMesh cube_mesh(int quads) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> index;
  const auto vertex = [&](const Eigen::Vector3i& at) {
    const auto [entry, is_new] =
        index.try_emplace({at[0], at[1], at[2]}, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(at.cast<double>());
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const bool far : {false, true})
      for (int i = 0; i < quads; ++i)
        for (int j = 0; j < quads; ++j) {
          const auto corner = [&](int du, int dv) {
            Eigen::Vector3i at;
            at[axis] = far ? quads : 0;
            at[(axis + 1) % 3] = i + du;
            at[(axis + 2) % 3] = j + dv;
            return vertex(at);
          };
          const std::uint32_t a = corner(0, 0), b = corner(1, 0), c = corner(1, 1),
                              d = corner(0, 1);
          mesh.faces.push_back(far ? TriangleMesh::Face{a, b, c} : TriangleMesh::Face{a, c, b});
          mesh.faces.push_back(far ? TriangleMesh::Face{a, c, d} : TriangleMesh::Face{a, d, c});
        }
  return mesh;
}

TEST(DecimateMesh, LeavesACubeExact) {
  const TriangleMesh cube = cube_mesh(16);
  const auto result = value_of(decimate_mesh(cube, {.faces = 40}));
  EXPECT_LE(result.mesh.faces.size(), 40u);
  EXPECT_TRUE(result.check.watertight());
  EXPECT_NEAR(enclosed_volume(result.mesh), 16.0 * 16.0 * 16.0, 1e-9);
  EXPECT_NEAR(surface_area(result.mesh), 6.0 * 16.0 * 16.0, 1e-9);
}

TEST(DecimateMesh, RandomScenesStayClosed) {
  const testing::RandomScenes scenes;
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    const TriangleMesh mesh = merge_views(scenes.scene(seed)).value().mesh;
    const auto result = decimate_mesh(mesh, {.faces = mesh.faces.size() / 4});
    ASSERT_THAT(result, IsOk()) << seed;
    EXPECT_TRUE(result->check.watertight()) << seed;
    EXPECT_LT(result->mesh.faces.size(), mesh.faces.size() / 2) << seed;
  }
}

TEST(DecimateMesh, LeavesAloneWhatIsSmallEnoughAndSaysWhatIsMissing) {
  const auto same =
      value_of(decimate_mesh(testing::torus_mesh(), {.faces = testing::torus_mesh().faces.size()}));
  EXPECT_EQ(same.mesh.faces, testing::torus_mesh().faces);
  EXPECT_THAT(decimate_mesh(testing::torus_mesh(), {}), HasError(ErrorKind::kBadInput));
}

}  // namespace
}  // namespace relief::fusion
