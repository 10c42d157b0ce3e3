#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/io/project_io.h"
#include "scan/io/e57/e57_file.h"
#include "scan/io/grids/pcd_grid_writer.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::TemporaryFolder;

// A ball `away` from the sensor.
RangeView ball_view(double away) {
  return testing::render(testing::sphere({0, 0, away}, 2.0),
                         Camera::pinhole(40, 30, {60, 60, 19.5, 14.5}));
}

std::string posed(RangeView view, const RigidMotion& pose) {
  view.world_from_view = pose;
  view.pose = PoseKind::kGuess;
  return encode_pcd_grid(view);
}

// As OpenNI's drivers write it.
RigidMotion half_turn() {
  return RigidMotion(Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()));
}

std::vector<std::string> names_of(const ScanProject& project) {
  std::vector<std::string> names;
  for (const RangeView& view : project.views) names.push_back(view.name);
  return names;
}

constexpr const char* kNoteOnPoses = "tell one and the same pose";

TEST(SettledViews, OnePoseInAllFilesIsNoPose) {
  const TemporaryFolder folder;
  folder.write("a.pcd", posed(ball_view(9), half_turn()));
  folder.write("b.pcd", posed(ball_view(10), half_turn()));
  const auto project = value_of(read_project(folder.path(), {.for_alignment = true}));
  for (const RangeView& view : project.views) {
    EXPECT_EQ(view.pose, PoseKind::kAbsent);
    EXPECT_TRUE(view.world_from_view.matrix().isIdentity());
  }
  EXPECT_THAT(project.notes, Contains(HasSubstr(kNoteOnPoses)));
}

// Merging takes views where they are, and conversions keep all of them.
TEST(SettledViews, AllIsKeptWhereNoPosesAreLookedFor) {
  const TemporaryFolder folder;
  folder.write("a.pcd", posed(ball_view(9), half_turn()));
  folder.write("b.pcd", posed(ball_view(9), half_turn()));
  const auto project = value_of(read_project(folder.path()));
  ASSERT_EQ(project.views.size(), 2u);
  EXPECT_TRUE(project.views[1].world_from_view.isApprox(half_turn()));
  EXPECT_THAT(project.notes, Contains(HasSubstr("leave copies out")));
}

TEST(SettledViews, PosesThatTellOfViewsAreKept) {
  const TemporaryFolder folder;
  folder.write("a.pcd", posed(ball_view(9), half_turn()));
  const auto of_one = value_of(read_project(folder / "a.pcd", {.for_alignment = true}));
  EXPECT_EQ(of_one.views[0].pose, PoseKind::kGuess);
  folder.write("b.pcd", posed(ball_view(10), Eigen::Translation3d(1, 0, 0) * half_turn()));
  const auto different = value_of(read_project(folder.path(), {.for_alignment = true}));
  EXPECT_EQ(different.views[0].pose, PoseKind::kGuess);
  EXPECT_THAT(different.notes, Not(Contains(HasSubstr(kNoteOnPoses))));
  folder.write("b.pcd", posed(ball_view(10), half_turn()));
  const auto of_one_frame =
      value_of(read_project(folder.path(), {.shared_frame = true, .for_alignment = true}));
  EXPECT_EQ(of_one_frame.views[1].pose, PoseKind::kGuess);
  EXPECT_TRUE(of_one_frame.views[1].world_from_view.isApprox(half_turn()));
}

TEST(SettledViews, CopiesWithoutPosesAreLeftOut) {
  const TemporaryFolder folder;
  RangeView coloured = ball_view(9);
  coloured.colours = Grid<Colour>(40, 30, Colour{7, 8, 9});
  folder.write("1.pcd", encode_pcd_grid(ball_view(9)));
  folder.write("2.pcd", encode_pcd_grid(ball_view(10)));
  folder.write("3.pcd", encode_pcd_grid(ball_view(9)));
  folder.write("color_1.pcd", encode_pcd_grid(coloured));
  const auto project = value_of(read_project(folder.path(), {.for_alignment = true}));
  EXPECT_THAT(names_of(project), ElementsAre("2", "color_1"));
  EXPECT_THAT(project.notes,
              Contains(HasSubstr("the ranges of 2 of 4 views are those of another view")));
}

// Points that a file tells to lie in one frame do.
TEST(SettledViews, ScansOfOneFileKeepItsFrame) {
  const TemporaryFolder folder;
  const auto path = folder / "two.e57";
  std::vector<RangeView> views{ball_view(9), ball_view(10)};
  for (RangeView& view : views) view.pose = PoseKind::kGuess;
  views[0].name = "a";
  views[1].name = "b";
  ASSERT_THAT(write_e57(views, path), IsOk());
  const auto project = value_of(read_project(path, {.for_alignment = true}));
  for (const RangeView& view : project.views) EXPECT_EQ(view.pose, PoseKind::kGuess);
}

TEST(SettledViews, CopiesWithPosesAreTold) {
  const TemporaryFolder folder;
  folder.write("a.pcd", posed(ball_view(9), half_turn()));
  folder.write("b.pcd", posed(ball_view(9), Eigen::Translation3d(1, 0, 0) * half_turn()));
  const auto project = value_of(read_project(folder.path(), {.for_alignment = true}));
  EXPECT_EQ(project.views.size(), 2u);
  EXPECT_THAT(project.notes, Contains(HasSubstr("as of b and a: leave copies out")));
}

}  // namespace
}  // namespace relief
