#include "scan/io/project/ptx_views.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/io/project_io.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using testing::TemporaryFolder;
using testing::value_of;

// Of a sphere, from places beside each other; those that are not posed have the identity.
std::vector<RangeView> scans(const std::vector<bool>& posed) {
  std::vector<RangeView> views;
  for (const bool is_posed : posed) {
    const double x = 0.3 * static_cast<double>(views.size() + 1);
    RangeView view = testing::render(testing::sphere({0, 0, 0}, 1.0),
                                     Camera::pinhole(40, 30, {50, 50, 19.5, 14.5}),
                                     testing::look_at({x, -7.0 / 3.0, 1.0}, {0, 0, 0}));
    if (!is_posed) view.world_from_view = RigidMotion::Identity();
    views.push_back(std::move(view));
  }
  return views;
}

std::vector<PoseKind> poses_read(const std::vector<bool>& posed,
                                 const ReadProjectOptions& options = {}) {
  const TemporaryFolder folder;
  EXPECT_THAT(write_ptx(scans(posed), folder / "a.ptx"), IsOk());
  const ScanProject project = value_of(read_project(folder / "a.ptx", options));
  std::vector<PoseKind> poses;
  for (const RangeView& view : project.views) poses.push_back(view.pose);
  return poses;
}

constexpr PoseKind kNone = PoseKind::kAbsent, kGuess = PoseKind::kGuess;

TEST(PtxViews, TheOneScanWithTheIdentityIsWhatTheOthersWereRegisteredTo) {
  EXPECT_EQ(poses_read({false, true, true}), (std::vector{kGuess, kGuess, kGuess}));
  EXPECT_EQ(poses_read({true, false}), (std::vector{kGuess, kGuess}));
}

TEST(PtxViews, SeveralWithTheIdentityAreNotRegistered) {
  EXPECT_EQ(poses_read({false, false, true}), (std::vector{kNone, kNone, kGuess}));
  EXPECT_EQ(poses_read({false, false}), (std::vector{kNone, kNone}));
  EXPECT_EQ(poses_read({false}), (std::vector{kNone}));
}

TEST(PtxViews, PosesThatAreNotToBeTakenAreNot) {
  EXPECT_EQ(poses_read({false, true, true}, {.ignore_viewpoints = true}),
            (std::vector{kNone, kNone, kNone}));
}

TEST(PtxViews, AFolderOfFilesCountsAsOneFile) {
  const TemporaryFolder folder;
  const auto views = scans({false, true, true});
  for (std::size_t i = 0; i < views.size(); ++i)
    ASSERT_THAT(write_ptx({views[i]}, folder / (std::to_string(i) + ".ptx")), IsOk());
  const ScanProject project = value_of(read_project(folder.path()));
  ASSERT_EQ(project.views.size(), 3u);
  EXPECT_EQ(project.views[0].pose, PoseKind::kGuess);
  EXPECT_THAT(project.notes, Contains(HasSubstr("view 0: its matrix is the identity")));
}

TEST(PtxViews, PlacesAreFound) {
  const TemporaryFolder folder;
  ASSERT_THAT(write_ptx(scans({true, true}), folder / "a.ptx"), IsOk());
  const ProjectSpec spec = value_of(read_project_spec(folder / "a.ptx", {}));
  ASSERT_TRUE(spec.views[1].grid_options.ptx);
  EXPECT_EQ(spec.views[0].grid_options.ptx->end, spec.views[1].grid_options.ptx->begin);
}

}  // namespace
}  // namespace relief
