#include "scan/io/project/poses/poses_of_scans.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

std::string pcd(const std::string& viewpoint) {
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 2\n"
         "VIEWPOINT " +
         viewpoint + "\nPOINTS 4\nDATA ascii\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n";
}

class PosesOfScans : public ::testing::Test {
 protected:
  // Two scans with poses of these numbers in PCL's order: a quaternion with w first.
  void write_scans(const std::string& first, const std::string& second) {
    folder_.write("a.pcd", pcd(first));
    folder_.write("b.pcd", pcd(second));
  }
  ProjectSpec read(const ReadProjectOptions& options = {}) {
    return value_of(read_project_spec(folder_.path(), options));
  }

  const std::string kIdentity = "0 0 0 1 0 0 0";
  const std::string kPoses = "1 2 3 0 0 0 1\n4 5 6 0 0 0 1\n";
  testing::TemporaryFolder folder_;
};

TEST_F(PosesOfScans, AreThoseOfATrajectory) {
  write_scans(kIdentity, kIdentity);
  folder_.write("poses.txt", kPoses);
  const ProjectSpec spec = read();
  EXPECT_EQ(spec.views.at(1).world_from_view.translation(), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(spec.views[1].pose, PoseKind::kGuess);
  EXPECT_THAT(spec.notes, Contains(HasSubstr("poses from")));
}

TEST_F(PosesOfScans, AreThoseOfAFileThatNamesThem) {
  write_scans(kIdentity, kIdentity);
  folder_.write("pose.json",
                R"({"b.pcd": [[1,0,0,7],[0,1,0,0],[0,0,1,0],[0,0,0,1]],
                    "a.pcd": [[1,0,0,8],[0,1,0,0],[0,0,1,0],[0,0,0,1]]})");
  const ProjectSpec spec = read();
  EXPECT_EQ(spec.views.at(0).world_from_view(0, 3), 8.0);
  EXPECT_EQ(spec.views.at(1).world_from_view(0, 3), 7.0);
}

TEST_F(PosesOfScans, FilesThatAreNotReadAreNamed) {
  write_scans(kIdentity, kIdentity);
  folder_.write("pose.json", R"({"b": {"x": 1}})");
  EXPECT_THAT(read().notes, Contains(HasSubstr("pose.json: is not read")));
  folder_.write("pose.json", R"([[[1,0,0,7],[0,2,0,0],[0,0,1,0],[0,0,0,1]]])");
  EXPECT_THAT(read().notes, Contains(HasSubstr("poses are not taken: ")));
}

TEST_F(PosesOfScans, DoNotReplaceViewpoints) {
  write_scans(kIdentity, "1 0 0 1 0 0 0");
  folder_.write("poses.txt", kPoses);
  const ProjectSpec spec = read();
  EXPECT_EQ(spec.views.at(0).pose, PoseKind::kAbsent);
  EXPECT_THAT(spec.notes, Contains(HasSubstr("--ignore-viewpoint")));
  ReadProjectOptions options;
  options.ignore_viewpoints = true;
  EXPECT_EQ(read(options).views.at(0).pose, PoseKind::kGuess);
  write_scans("1 0 0 1 0 0 0", "1 0 0 1 0 0 0");  // A turn of the axes.
  EXPECT_EQ(read().views.at(0).pose, PoseKind::kGuess);
}

TEST_F(PosesOfScans, NoFileOfPosesIsNothingToTell) {
  write_scans(kIdentity, kIdentity);
  folder_.write("readme.txt", "Two scans.\n");
  EXPECT_THAT(read().notes, Not(Contains(HasSubstr("pose"))));
}

}  // namespace
}  // namespace relief
