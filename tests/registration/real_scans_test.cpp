#include <algorithm>

#include <gtest/gtest.h>

#include "registration/align_views.h"
#include "scan/io/poses_io.h"
#include "scan/io/project_io.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/test_data.h"

namespace relief {
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
  const auto project = read_project(folder / "scan.json");
  ASSERT_TRUE(project.ok()) << project.error().message;
  const auto truth = poses_in(folder / "truth.json");
  const auto aligned = align_views(project->views);
  ASSERT_TRUE(aligned.ok());
  EXPECT_TRUE(aligned->complete());
  const auto errors =
      testing::mean_displacements(project->views, aligned->world_from_view(), truth);
  RecordProperty("largest_mean_displacement_um", static_cast<int>(1000 * largest(errors)));
  EXPECT_LT(largest(errors), 0.03);  // mm; the noise is 0.15, the spacing 0.47
}

TEST(RealScans, TheBunnyStaysWhereItWasPublishedAndFitsBetter) {
  RELIEF_REQUIRE_TEST_DATA(folder, "bunny");
  const auto project = read_project(folder / "bun.conf");
  ASSERT_TRUE(project.ok()) << project.error().message;
  const auto published = testing::poses_of(project->views);
  auto held = project->views;
  for (auto& view : held) view.pose = PoseKind::kKnown;
  const auto before = align_views(held);
  const auto after = align_views(project->views);
  ASSERT_TRUE(after.ok());
  EXPECT_TRUE(after->complete());
  EXPECT_LT(after->rms, before->rms);
  EXPECT_LT(largest(testing::mean_displacements(held, after->world_from_view(), published)),
            0.3e-3);
}

TEST(RealScans, TheBunnyIsFoundAgainFromFiveDegreesOff) {
  RELIEF_REQUIRE_TEST_DATA(folder, "bunny");
  const auto project = read_project(folder / "bun.conf");
  ASSERT_TRUE(project.ok()) << project.error().message;
  const auto from_published = align_views(project->views);
  const auto from_afar =
      align_views(testing::perturbed(project->views, {-0.02, 0.1, 0.0}, 0.087, 3e-3));
  EXPECT_LT(largest(testing::mean_displacements(project->views, from_afar->world_from_view(),
                                                from_published->world_from_view())),
            5e-6);
}

}  // namespace
}  // namespace relief
