#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "relief/io/project_io.h"
#include "tests/support/result_matchers.h"
#include "tests/support/test_data.h"

namespace relief {
namespace {

// Distances from samples of `from` to the surface `onto` along its rays, where they project.
std::vector<double> distances(const RangeView& from, const RangeView& onto) {
  std::vector<double> result;
  const RigidMotion onto_from = onto.world_from_view.inverse() * from.world_from_view;
  for (int v = 0; v < from.height(); v += 3) {
    for (int u = 0; u < from.width(); u += 3) {
      if (!from.has_sample(u, v)) continue;
      const Eigen::Vector3d point = onto_from * from.point(u, v);
      const auto pixel = onto.camera.project(point);
      if (!pixel) continue;
      const int pu = static_cast<int>(std::lround(pixel->x()));
      const int pv = static_cast<int>(std::lround(pixel->y()));
      if (onto.has_sample(pu, pv)) result.push_back((onto.point(pu, pv) - point).norm());
    }
  }
  return result;
}

double fraction_below(const std::vector<double>& values, double limit) {
  std::size_t below = 0;
  for (const double value : values) below += value < limit ? 1 : 0;
  return static_cast<double>(below) / static_cast<double>(values.size());
}

TEST(RealScans, NeighbouringBunnyScansMeetInTheirPublishedPoses) {
  RELIEF_REQUIRE_TEST_DATA(path, "bunny/bun.conf");
  const auto project = value_of(read_project(path));
  ASSERT_EQ(project.views.size(), 10u);
  const RangeView &front = project.views[0], &quarter = project.views[1];
  ASSERT_EQ(front.name, "bun000");
  ASSERT_EQ(quarter.name, "bun045");
  const auto meeting = distances(front, quarter);
  ASSERT_GT(meeting.size(), 1000u);
  // Half of the samples of one scan are seen by the other, within about the sample spacing.
  EXPECT_GT(fraction_below(meeting, 1.5 * sample_spacing(front)), 0.6);
}

TEST(RealScans, BunnyKeepsItsPointsAndIsSeenFromPositiveZ) {
  RELIEF_REQUIRE_TEST_DATA(path, "bunny/bun000.ply");
  const auto project = value_of(read_project(path));
  const RangeView& view = project.views.front();
  EXPECT_EQ(view.sample_count(), 40256u);
  EXPECT_LT(view.camera.ray(256, 200).direction.z(), -0.99);
  ASSERT_TRUE(view.camera.can_project());
}

TEST(RealScans, PanelIsAPinholeWithNormalsTowardsTheSensor) {
  RELIEF_REQUIRE_TEST_DATA(path, "panel/panel-small.ply");
  const auto project = value_of(read_project(path));
  const RangeView& view = project.views.front();
  EXPECT_EQ(view.camera.model(), Camera::Model::kPinholeGl);
  EXPECT_NEAR(view.camera.intrinsics().fx, 955.5, 1e-2);
  EXPECT_EQ(view.sample_count(), 116408u);
  ASSERT_TRUE(view.has_normals());
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_normal(u, v)) {
        ASSERT_LT(view.normals(u, v).cast<double>().dot(view.camera.ray(u, v).direction), 0.0);
      }
}

TEST(RealScans, BearHasTwentyPinholeViewsWithNormals) {
  RELIEF_REQUIRE_TEST_DATA(path, "bear/scan.json");
  const auto project = value_of(read_project(path));
  ASSERT_EQ(project.views.size(), 20u);
  for (const auto& view : project.views) {
    EXPECT_TRUE(view.has_normals());
    EXPECT_EQ(view.pose, PoseKind::kGuess);
  }
}

}  // namespace
}  // namespace relief
