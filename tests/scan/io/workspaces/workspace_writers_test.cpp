#include "scan/io/workspaces/workspace_writers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/workspaces/colmap/colmap_model.h"
#include "scan/io/workspaces/meshlab_mlp.h"
#include "scan/io/workspaces/pose_beside.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::TemporaryFolder;

// Poses whose numbers no short decimal holds.
std::vector<RangeView> three_posed_views() {
  std::vector<RangeView> views(3);
  for (int i = 0; i < 3; ++i) {
    RangeView& view = views[static_cast<std::size_t>(i)];
    view.name = "v " + std::to_string(i);
    view.camera = Camera::pinhole(24, 20, {31.0 / 3, -30, 11.1, 9.3});
    view.world_from_view = Eigen::Translation3d(i / 3.0, 1e3 / 7.0, -1e-3 / 9.0) *
                           Eigen::AngleAxisd(0.1 + 3 * i, Eigen::Vector3d(1, 2, 3).normalized());
  }
  return views;
}

double difference(const RigidMotion& a, const RigidMotion& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

TEST(WorkspaceWriters, PosesSurviveMlp) {
  const auto views = three_posed_views();
  const auto spec = value_of(
      parse_meshlab_mlp(meshlab_mlp_text(views, {"a<&\">.ply", "b.ply", "c/d.ply"}), "x/y.mlp"));
  EXPECT_EQ(*spec.views[0].grid, "x/a<&\">.ply");
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LT(difference(spec.views[i].world_from_view, views[i].world_from_view), 1e-12);
}

// MeshLab 2020.09 ends with a fault on rows that end in a number.
TEST(WorkspaceWriters, RowsOfMlpEndInABlank) {
  const std::string text = meshlab_mlp_text(three_posed_views(), {"a.ply", "b.ply", "c.ply"});
  const std::size_t rows = text.find("<MLMatrix44>") + std::string("<MLMatrix44>").size();
  const std::string matrix = text.substr(rows, text.find("</MLMatrix44>") - rows);
  std::size_t ends = 0;
  for (std::size_t at = matrix.find(" \n"); at != std::string::npos;
       at = matrix.find(" \n", at + 1))
    ++ends;
  EXPECT_EQ(ends, 4u);
}

TEST(WorkspaceWriters, PosesSurviveXf) {
  const TemporaryFolder folder;
  const auto views = three_posed_views();
  ASSERT_TRUE(write_xf_folder(views, folder / "new"));
  for (const RangeView& view : views) {
    const auto pose = value_of(value_of(pose_beside(folder / "new" / (view.name + ".ply"))));
    EXPECT_LT(difference(pose, view.world_from_view), 1e-12);
  }
}

TEST(WorkspaceWriters, PosesAndCamerasSurviveColmap) {
  const TemporaryFolder folder;
  const auto views = three_posed_views();
  ASSERT_TRUE(write_colmap_text(views, folder / "new"));
  const auto model = value_of(read_colmap_model(folder / "new"));
  ASSERT_EQ(model.images.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(model.images[i].name, views[i].name + ".png");
    EXPECT_LT(difference(model.images[i].world_from_view, views[i].world_from_view), 1e-12);
    EXPECT_EQ(model.cameras[i].intrinsics.fx, 31.0 / 3);
    EXPECT_EQ(model.cameras[i].intrinsics.cx, 11.1 + 0.5);
  }
}

TEST(WorkspaceWriters, ErrorsNameTheView) {
  const TemporaryFolder folder;
  auto views = three_posed_views();
  views[1].name = "a/b";
  EXPECT_THAT(write_xf_folder(views, folder / "new"), HasError("'a/b' is no file name"));
  views[1].name = views[0].name;
  EXPECT_THAT(write_xf_folder(views, folder / "new"), HasError("two views"));
  views[1].name = "b";
  views[1].camera = Camera::pinhole_gl(4, 4, {1, 1, 1, 1});
  EXPECT_THAT(write_colmap_text(views, folder / "new"),
              HasError("view b has the camera 'pinhole_gl'"));
  EXPECT_EQ(folder.size(), 0u);
  const auto file = folder.write("file", "");
  EXPECT_THAT(write_xf_folder(views, file), HasError(ErrorKind::kCannotWrite));
}

}  // namespace
}  // namespace relief
