#include "scan/io/project/poses/poses_of_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::Contains;
using testing::HasError;
using ::testing::HasSubstr;

// A file with poses of the views `front` and `side`, 1 and 2 along x.
struct FormOfPoses {
  const char* name;
  const char* file;
  const char* text;
};

class PosesOfViews : public ::testing::Test {
 protected:
  Result<std::vector<RigidMotion>> read(const std::string& file, const std::string& text) {
    folder_.write(file, text);
    return read_poses_of_views(folder_ / file, {"front", "side"}, notes_);
  }

  testing::TemporaryFolder folder_;
  std::vector<std::string> notes_;
};

class FormsOfPoses : public PosesOfViews, public ::testing::WithParamInterface<FormOfPoses> {};

TEST_P(FormsOfPoses, AreRead) {
  const auto poses = value_of(read(GetParam().file, GetParam().text));
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].translation(), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(poses[1].translation(), Eigen::Vector3d(2, 0, 0));
  EXPECT_TRUE(holds_poses_alone(folder_ / GetParam().file));
}

INSTANTIATE_TEST_SUITE_P(
    Forms, FormsOfPoses,
    ::testing::Values(
        FormOfPoses{"Tum", "truth.tum", "0 1 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n"},
        FormOfPoses{"TumText", "truth.txt", "# time tx\n0 1 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n"},
        FormOfPoses{"Log", "truth.log",
                    "0 0 1\n1 0 0 1\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
                    "1 1 2\n1 0 0 2\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"},
        FormOfPoses{"Matrices", "truth.txt", "1 0 0 1 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 0\n"},
        FormOfPoses{"Table", "truth.csv",
                    "name,tx,ty,tz,qx,qy,qz,qw\nside,2,0,0,0,0,0,1\nfront,1,0,0,0,0,0,1\n"},
        FormOfPoses{"Json", "truth.json",
                    R"({"side": [[1,0,0,2],[0,1,0,0],[0,0,1,0]],
                        "front": [[1,0,0,1],[0,1,0,0],[0,0,1,0]]})"},
        FormOfPoses{"Report", "report.json",
                    R"({"align": {"views": [
                        {"name": "side", "world_from_view":
                          [[1,0,0,2],[0,1,0,0],[0,0,1,0],[0,0,0,1]]},
                        {"name": "front", "world_from_view":
                          [[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}})"}),
    [](const auto& form) { return std::string(form.param.name); });

TEST_F(PosesOfViews, OfAnotherCountAreAnError) {
  EXPECT_THAT(read("truth.log", "0 0 1\n1 0 0 1\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"),
              HasError("1 poses for 2 views"));
  EXPECT_THAT(read("truth.csv", "name,tx,ty,tz,qx,qy,qz,qw\nx,2,0,0,0,0,0,1\n"),
              HasError("1 poses for 2 views, and neither names nor numbers tell"));
}

TEST_F(PosesOfViews, ThatAreLostAreNamed) {
  EXPECT_THAT(read("truth.tum", "0 1 0 0 0 0 0 1\n1 nan 0 0 0 0 0 1\n"),
              HasError("truth.tum: has no pose for view side"));
  EXPECT_THAT(notes_, Contains(HasSubstr("1 of its 2 poses are no motion")));
}

TEST_F(PosesOfViews, ThatAreNoneAreNamedWithTheirLine) {
  EXPECT_THAT(read("poses.txt", "0 1 0 0 0 0 0 2\n"), HasError("poses.txt: line 1: not a rigid"));
  EXPECT_TRUE(holds_poses_alone(folder_ / "poses.txt"));
}

TEST_F(PosesOfViews, AreNotPoints) {
  EXPECT_THAT(read("truth.tum", "1 2\n3 4\n"), HasError("no form of poses"));
  folder_.write("points.txt", "1 2 3\n4 5 6\n");
  EXPECT_FALSE(holds_poses_alone(folder_ / "points.txt"));
  folder_.write("scan.json", R"({"format": "relief-scan", "views": []})");
  EXPECT_FALSE(holds_poses_alone(folder_ / "scan.json"));
}

}  // namespace
}  // namespace relief
