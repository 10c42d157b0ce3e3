#include "relief/fusion/decimate_mesh.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stop_token>

#include <gtest/gtest.h>

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

TEST(DecimateMesh, KeepsVerticesWithTheirAttributes) {
  TriangleMesh mesh = testing::torus_mesh();
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.quality[v] = static_cast<float>(mesh.vertices[v].x());
  const auto result = value_of(decimate_mesh(mesh, {.faces = 2000}));
  const TriangleMesh& fewer = result.mesh;
  ASSERT_EQ(fewer.quality.size(), fewer.vertices.size());
  ASSERT_EQ(fewer.filled.size(), fewer.vertices.size());
  ASSERT_EQ(fewer.normals.size(), fewer.vertices.size());
  for (std::size_t v = 0; v < fewer.vertices.size(); ++v)
    EXPECT_EQ(fewer.quality[v], static_cast<float>(fewer.vertices[v].x()));
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
