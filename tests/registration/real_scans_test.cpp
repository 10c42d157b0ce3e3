#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "registration/pairwise/icp.h"
#include "relief/io/project_io.h"
#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/registration/relief_views.h"
#include "tests/support/result_matchers.h"
#include "tests/support/test_data.h"

namespace relief::registration {
namespace {

std::vector<RigidMotion> poses_in(const std::filesystem::path& path) {
  std::vector<RigidMotion> poses;
  for (const NamedPose& pose : read_poses(path).value()) poses.push_back(pose.world_from_view);
  return poses;
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

TEST(RealScans, TwentyViewsOfABearReturnToTheirTruePoses) {
  RELIEF_REQUIRE_TEST_DATA(folder, "bear");
  const auto project = value_of(read_project(folder / "scan.json"));
  const auto truth = poses_in(folder / "truth.json");
  const auto aligned = value_of(align_views(project.views));
  EXPECT_TRUE(aligned.complete());
  const auto errors = testing::mean_displacements(project.views, aligned.world_from_view(), truth);
  RecordProperty("largest_mean_displacement_um", static_cast<int>(1000 * largest(errors)));
  EXPECT_LT(largest(errors), 0.03);  // mm; the noise is 0.15, the spacing 0.47
}

TEST(RealScans, TheBunnyStaysWhereItWasPublishedAndFitsBetter) {
  RELIEF_REQUIRE_TEST_DATA(folder, "bunny");
  const auto project = value_of(read_project(folder / "bun.conf"));
  const auto published = testing::poses_of(project.views);
  auto held = project.views;
  for (auto& view : held) view.pose = PoseKind::kKnown;
  const auto before = align_views(held);
  const auto after = value_of(align_views(project.views));
  EXPECT_TRUE(after.complete());
  EXPECT_LT(after.rms, before->rms);
  EXPECT_LT(largest(testing::mean_displacements(held, after.world_from_view(), published)), 0.3e-3);
}

TEST(RealScans, TheBunnyIsFoundAgainFromFiveDegreesOff) {
  RELIEF_REQUIRE_TEST_DATA(folder, "bunny");
  const auto project = value_of(read_project(folder / "bun.conf"));
  const auto from_published = align_views(project.views);
  const auto from_afar =
      align_views(testing::perturbed(project.views, {-0.02, 0.1, 0.0}, 0.087, 3e-3));
  EXPECT_LT(largest(testing::mean_displacements(project.views, from_afar->world_from_view(),
                                                from_published->world_from_view())),
            5e-6);
}

// Every other pixel of every other row, from (u, v) on: another view of the same sensor, whose
// samples have errors of their own.
RangeView decimated(const RangeView& view, int u0, int v0) {
  RangeView result;
  const int width = view.width() / 2, height = view.height() / 2;
  const PinholeIntrinsics& full = view.camera.intrinsics();
  result.camera = Camera::pinhole_gl(
      width, height, {0.5 * full.fx, 0.5 * full.fy, 0.5 * (full.cx - u0), 0.5 * (full.cy - v0)});
  result.range = Grid<double>(width, height);
  result.normals = Grid<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero());
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      result.range(u, v) = view.range(2 * u + u0, 2 * v + v0);
      result.normals(u, v) = view.normals(2 * u + u0, 2 * v + v0);
    }
  }
  return result;
}

// The panel's relief is real, and so are its normals and the noise of its range.
TEST(RealScans, TwoHalvesOfThePanelMeetByTheirNormalMaps) {
  RELIEF_REQUIRE_TEST_DATA(panel, "panel");
  ReadProjectOptions read_options;
  read_options.fc_file = panel / "panel-small.fc";
  const auto project = value_of(read_project(panel / "panel-small-conf.ply", read_options));
  const RangeView& view = project.views.front();
  ASSERT_EQ(view.camera.model(), Camera::Model::kPinholeGl);
  const RangeView one = decimated(view, 0, 0), other = decimated(view, 1, 1);
  const ViewSurface target(one), source(other);
  RigidTangent offset;
  offset << 0.01, -0.005, 0.01, 1.5 * target.spacing(), -1.0 * target.spacing(), 0.0;
  const RigidMotion guess = Eigen::Translation3d(source.centre()) * motion_from_tangent(offset) *
                            Eigen::Translation3d(-source.centre());
  const auto error = [&](bool maps) {
    const auto found = align_pair(source, target, guess, {.normal_maps = maps});
    const double moved =
        testing::mean_displacement(other, found.target_from_source, RigidMotion::Identity());
    RecordProperty(maps ? "with_maps" : "without_maps", std::to_string(moved / target.spacing()));
    return moved / target.spacing();
  };
  EXPECT_LT(error(true), 0.2);
  error(false);
}

// Two centres, view 48 fits no projection: published poses, and poses four degrees and 2 mm off.
TEST(RealScans, AllViewsOfTheDragonStayAtGivenPoses) {
  RELIEF_REQUIRE_TEST_DATA(folder, "dragon");
  const auto project = value_of(read_project(folder / "dragonStandRight.conf"));
  const auto published = value_of(align_views(project.views));
  const auto off =
      value_of(align_views(testing::perturbed(project.views, {-0.01, 0.12, 0.0}, 0.07, 2e-3)));
  for (std::size_t i = 0; i < project.views.size(); ++i) {
    EXPECT_EQ(published.views[i].status, PoseStatus::kVerified) << published.views[i].reason;
    EXPECT_EQ(off.views[i].status, PoseStatus::kVerified) << off.views[i].reason;
  }
  EXPECT_LT(largest(testing::mean_displacements(project.views, off.world_from_view(),
                                                published.world_from_view())),
            2e-5);
}

std::vector<RangeView> without_poses(const std::vector<RangeView>& views, std::size_t step) {
  std::vector<RangeView> shuffled;
  for (std::size_t i = 0; i < views.size(); ++i) {
    shuffled.push_back(views[(step * i + 3) % views.size()]);
    shuffled.back().pose = PoseKind::kAbsent;
    shuffled.back().world_from_view = RigidMotion::Identity();
  }
  return shuffled;
}

TEST(RealScans, TheDragonIsPlacedWithoutPoses) {
  RELIEF_REQUIRE_TEST_DATA(folder, "dragon");
  const auto project = value_of(read_project(folder / "dragonStandRight.conf"));
  std::vector<RigidMotion> published;
  for (std::size_t i = 0; i < project.views.size(); ++i)
    published.push_back(project.views[(7 * i + 3) % project.views.size()].world_from_view);
  const auto views = without_poses(project.views, 7);
  const auto aligned = value_of(align_views(views));
  EXPECT_TRUE(aligned.complete());
  EXPECT_LT(largest(testing::mean_displacements(views, aligned.world_from_view(), published)),
            2e-3);
}

TEST(RealScans, FiveViewsOfARoomByAKinectArePlacedWithoutPoses) {
  RELIEF_REQUIRE_TEST_DATA(folder, "kinect");
  const auto project = value_of(read_project(folder));
  // The poses of these files hold a half turn that is none. In both orders.
  for (const std::size_t stride : {1, 2}) {
    const auto aligned = value_of(align_views(without_poses(project.views, stride)));
    EXPECT_TRUE(aligned.complete()) << stride;
    EXPECT_LT(aligned.rms, 0.02);  // m; a step of the ranges is 0.023 at 2.85 m
  }
}

}  // namespace
}  // namespace relief::registration
