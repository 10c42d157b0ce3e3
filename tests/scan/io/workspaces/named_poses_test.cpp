#include "scan/io/workspaces/rgbd/poses/named_poses.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/workspaces/rgbd/rgbd_folder.h"
#include "tests/scan/io/small_files.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::npy_array;
using testing::TemporaryFolder;

// y of the view is z of the world; the eye is at (x, 6, 7).
std::string rows(int x) {
  return "[[1, 0, 0, " + std::to_string(x) + "], [0, 0, -1, 6], [0, 1, 0, 7], [0, 0, 0, 1]]";
}

// Names in all fields and x of each pose.
std::vector<std::string> summary(const Result<PoseList>& read) {
  const PoseList poses = value_of(read);
  std::vector<std::string> text;
  for (std::size_t k = 0; k < poses.world_from_view.size(); ++k) {
    const auto& pose = poses.world_from_view[k];
    text.emplace_back();
    for (const auto& [field, names] : poses.names) text.back() += names.at(k) + "@";
    text.back() += pose ? std::to_string(std::lround((*pose)(0, 3))) : "lost";
    if (!pose) continue;
    EXPECT_EQ(pose->translation().tail<2>(), Eigen::Vector2d(6, 7));
    EXPECT_NEAR(pose->linear()(2, 1), 1.0, 1e-12);
  }
  return text;
}

TEST(JsonPoses, HaveTheirNamesInManyPlaces) {
  const auto parse = [](const std::string& text) { return summary(parse_json_poses(text, "p")); };
  EXPECT_THAT(parse("{\"a\": " + rows(1) + ", \"b\": " + rows(2) + "}"), ElementsAre("a@1", "b@2"));
  EXPECT_THAT(parse("{\"K\": [[1,0,0],[0,1,0],[0,0,1]], \"7\": " + rows(1) + "}"),
              ElementsAre("7@1"));
  EXPECT_THAT(
      parse("{\"a\": {\"pose\": " + rows(1) + ", \"w\": 3}, \"b\": {\"pose\": " + rows(2) + "}}"),
      ElementsAre("a@1", "b@2"));
  EXPECT_THAT(parse("[{\"T\": " + rows(1) + ", \"name\": \"x/a.png\"}]"), ElementsAre("x/a.png@1"));
  EXPECT_THAT(parse("[{\"T\": " + rows(1) + ", \"id\": 12, \"file\": \"a\"}]"),
              ElementsAre("a@12@1"));
  // Of nerfstudio: the list of frames, not the one matrix beside it.
  EXPECT_THAT(parse("{\"frames\": [{\"T\": " + rows(1) + "}, {\"T\": " + rows(2) +
                    "}], \"applied_transform\": " + rows(3) + ", \"train\": [\"a\"]}"),
              ElementsAre("1", "2"));
  EXPECT_THAT(parse("[" + rows(1) + ", " + rows(2) + "]"), ElementsAre("1", "2"));
  EXPECT_THAT(parse("{\"w\": 3, \"poses\": {\"a\": " + rows(1) + "}}"), ElementsAre("a@1"));
  EXPECT_THAT(parse("{\"a\": [1,0,0,5, 0,0,-1,6, 0,1,0,7]}"), ElementsAre("a@5"));
  EXPECT_THAT(parse(rows(1)), ElementsAre());
  EXPECT_THAT(parse("{\"a\": [1, 2, 3], \"b\": null}"), ElementsAre());
  EXPECT_THAT(parse("not JSON"), ElementsAre());
}

TEST(JsonPoses, ErrorsNameTheMatrix) {
  EXPECT_THAT(parse_json_poses("{\"poses\": {\"3\": [2,0,0,5, 0,0,-1,6, 0,1,0,7]}}", "p.json"),
              HasError("p.json: the matrix of poses.3", "not a rigid motion"));
}

TEST(PoseTable, HasNamesAndHeadings) {
  const auto parse = [](const std::string& text) { return summary(parse_pose_table(text, "p")); };
  const std::string turned = " 0.7071067811865476 0 0 0.7071067811865476\n";
  EXPECT_THAT(parse("a.png 1 6 7" + turned + "# end\nb.png 2 6 7" + turned),
              ElementsAre("a.png@1", "b.png@2"));
  EXPECT_THAT(parse("a 1 6 7" + turned + "b nan nan nan nan nan nan nan\nc 0 0 0 0 0 0 0\n"),
              ElementsAre("a@1", "b@lost", "c@lost"));
  EXPECT_THAT(parse("frame,tx,ty,tz,qx,qy,qz,qw\n0,1,6,7,0.7071067811865476,0,0,"
                    "0.7071067811865476\n1,,,,,,,\n2,NaN,NaN,NaN,NaN,NaN,NaN,NaN\n"),
              ElementsAre("0@1", "1@lost", "2@lost"));
  EXPECT_THAT(parse("a 1 0 0 5 0 0 -1 6 0 1 0 7\nb 1 0 0 4 0 0 -1 6 0 1 0 7 0 0 0 1\n"),
              ElementsAre("a@5", "b@4"));
  EXPECT_THAT(parse("frame,tx,ty,tz,qx,qy,qz,qw\n0,1,6,7,0.7071067811865476,0,0,"
                    "0.7071067811865476\n"),
              ElementsAre("0@1"));
  EXPECT_THAT(parse("q_w;q_x;q_y;q_z;pos_x;pos_y;pos_z;file\n"
                    "0.7071067811865476;0.7071067811865476;0;0;1;6;7;a\n"),
              ElementsAre("a@1"));
  EXPECT_THAT(parse("1 2 3 4 5 6\n"), ElementsAre());
  EXPECT_THAT(parse("some words\n"), ElementsAre());
}

TEST(PoseTable, ErrorsNameTheLine) {
  const std::string heading = "frame,tx,ty,tz,qx,qy,qz,qw\n";
  EXPECT_THAT(parse_pose_table(heading + "0,1,6,7,2,0,0,0\n", "p.csv"),
              HasError("p.csv: line 2: not a rigid motion"));
  EXPECT_THAT(parse_pose_table(heading + "0,1,6,x,1,0,0,0\n", "p.csv"),
              HasError("line 2: expected a number, found 'x'"));
  EXPECT_THAT(parse_pose_table("a 1 6 7 0 0 0 1\nb 1 6\n", "p.txt"),
              HasError("line 2: expected a pose as on the lines above"));
}

TEST(NpyPoses, AreMatricesOrRows) {
  const std::vector<double> three = {1, 0, 0, 5, 0, 0, -1, 6, 0, 1, 0, 7};
  std::vector<double> two = three;
  two.insert(two.end(), three.begin(), three.end());
  EXPECT_THAT(summary(parse_npy_poses(npy_array("(3, 4)", three), "p")), ElementsAre("5"));
  EXPECT_THAT(summary(parse_npy_poses(npy_array("(2, 3, 4)", two), "p")), ElementsAre("5", "5"));
  EXPECT_THAT(summary(parse_npy_poses(npy_array("(2, 12)", two), "p")), ElementsAre("5", "5"));
  EXPECT_THAT(summary(parse_npy_poses(npy_array("(12, 2)", two), "p")), ElementsAre());
  EXPECT_THAT(summary(parse_npy_poses(npy_array("(0, 4, 4)", {}), "p")), ElementsAre());
  EXPECT_THAT(parse_npy_poses(npy_array("(1152921504606846977, 4, 4)", two), "p.npy"),
              HasError("the file ends"));
  EXPECT_THAT(parse_npy_poses(npy_array("(3, 12)", two), "p.npy"),
              HasError("p.npy: the file ends"));
  two[12] = 3.0;
  EXPECT_THAT(parse_npy_poses(npy_array("(2, 12)", two), "p.npy"),
              HasError("matrix 1", "rigid motion"));
  EXPECT_THAT(parse_npy_poses("not NumPy", "p.npy"), HasError("not a NumPy file"));
}

TEST(NpyPoses, MayBeTranslationsAndQuaternions) {
  const double half = std::sqrt(0.5);  // A quarter turn about x.
  std::vector<double> rows = {5, 6, 7, half, 0, 0, half, 0, 0, 0,   0,
                              0, 0, 0, 8,    6, 7, half, 0, 0, half};
  EXPECT_THAT(summary(parse_npy_poses(npy_array("(3, 7)", rows), "p")),
              ElementsAre("5", "lost", "8"));
  EXPECT_THAT(summary(parse_npy_poses(npy_array("(7, 3)", rows), "p")), ElementsAre());
  rows[17] = 3.0;
  EXPECT_THAT(parse_npy_poses(npy_array("(3, 7)", rows), "p.npy"),
              HasError("p.npy: row 2 is not a rigid motion"));
  rows[3] = 3.0;  // As angles of the joints of an arm.
  EXPECT_THAT(summary(parse_npy_poses(npy_array("(3, 7)", rows), "p")), ElementsAre());
}

class PosesByName : public ::testing::Test {
 protected:
  // Of views `depth/2.png` and `depth/10.png`, x of their poses; -1 without one.
  std::vector<int> x_of_views(std::vector<std::string>* notes = nullptr) const {
    for (const char* name : {"depth/2.png", "depth/10.png"})
      folder_.write(name, testing::png_head(4));
    const auto spec =
        value_of(read_rgbd_folder(folder_.path(), {PinholeIntrinsics{5, 5, 2, 2}, 1000.0}));
    if (notes) *notes = spec.notes;
    std::vector<int> x;
    for (const ViewSpec& view : spec.views)
      x.push_back(view.pose == PoseKind::kAbsent
                      ? -1
                      : static_cast<int>(std::lround(view.world_from_view(0, 3))));
    return x;
  }
  TemporaryFolder folder_;
};

TEST_F(PosesByName, AreMatchedByNameAndNumber) {
  std::vector<std::string> notes;
  folder_.write("poses.json", "{\"00010\": " + rows(1) + ", \"00002\": " + rows(2) + "}");
  EXPECT_EQ(x_of_views(&notes), (std::vector<int>{2, 1}));
  EXPECT_THAT(notes, Contains(HasSubstr("poses.json")));
  folder_.write("poses.json", "[{\"name\": \"images/10.jpg\", \"T\": " + rows(1) + "}]");
  EXPECT_EQ(x_of_views(), (std::vector<int>{-1, 1}));
  folder_.write("poses.json", "[" + rows(1) + ", " + rows(2) + "]");
  EXPECT_EQ(x_of_views(), (std::vector<int>{1, 2}));
}

// Whichever field has the names, and whatever the alphabet says of their order.
TEST_F(PosesByName, AreMatchedByTheFieldThatNamesMostFrames) {
  folder_.write("poses.json",
                "[{\"camera\": \"left\", \"name\": \"10.png\", \"w\": 640, \"T\": " + rows(1) +
                    "}, {\"camera\": \"left\", \"name\": \"2.png\", \"w\": 640, \"T\": " + rows(2) +
                    "}]");
  EXPECT_EQ(x_of_views(), (std::vector<int>{2, 1}));
  folder_.write("poses.json", "{\"3\": " + rows(1) + ", \"11\": " + rows(2) + "}");
  std::vector<std::string> notes;
  EXPECT_EQ(x_of_views(&notes), (std::vector<int>{1, 2}));
  EXPECT_THAT(notes, Contains(HasSubstr("those of the depth maps plus 1")));
}

TEST_F(PosesByName, ThatBeginWithNoPoseAreNamedWithTheirLine) {
  std::vector<std::string> notes;
  const auto notes_on = [&](const std::string& text) {
    folder_.write("poses.txt", text);
    EXPECT_EQ(x_of_views(&notes), (std::vector<int>{-1, -1}));
    return ::testing::PrintToString(notes);
  };
  EXPECT_THAT(notes_on("# poses\n2 0 0 5 0 2 0 6 0 0 2 7\n"),
              AllOf(HasSubstr("poses.txt: line 2: the matrix is not a rigid motion"),
                    HasSubstr("the file is not read")));
  EXPECT_THAT(notes_on("0 1 6 7 0 0 0 2\n"), HasSubstr("poses.txt: line 1: not a rigid motion"));
  EXPECT_THAT(notes_on("1 2 3 4 5 6\n"), HasSubstr("has no form of poses that is known"));
}

TEST_F(PosesByName, OfOtherThingsAreNotTaken) {
  const std::vector<int> none = {-1, -1};
  folder_.write("hand_eye.json", "{\"cam2grp\": " + rows(1) + "}");
  EXPECT_EQ(x_of_views(), none);
  folder_.write("extrinsics.json",
                "{\"cam2imu\": " + rows(1) + ", \"lidar2cam\": " + rows(2) + "}");
  EXPECT_EQ(x_of_views(), none);
  folder_.write("annotations.json", "[" + rows(1) + ", " + rows(2) + "]");
  EXPECT_EQ(x_of_views(), none);
  // With errors, but not called poses.
  folder_.write("info.json", "{\"P\": [[5, 0, 7, 0], [0, 5, 8, 0], [0, 0, 1, 0]]}");
  folder_.write("metadata.npy", testing::npy_file("{'a': '|O'}", ""));
  EXPECT_EQ(x_of_views(), none);
}

TEST_F(PosesByName, OfTwoFilesThatDifferAreAnError) {
  folder_.write("poses.json", "{\"2\": " + rows(1) + ", \"10\": " + rows(2) + "}");
  folder_.write("others.json", "{\"2\": " + rows(3) + ", \"10\": " + rows(4) + "}");
  EXPECT_EQ(x_of_views(), (std::vector<int>{1, 2}));  // The one that is called poses.
  folder_.write("poses_new.json", "{\"2\": " + rows(1) + ", \"10\": " + rows(2) + "}");
  EXPECT_EQ(x_of_views(), (std::vector<int>{1, 2}));  // The same.
  folder_.write("poses_new.json", "{\"2\": " + rows(1) + ", \"10\": " + rows(3) + "}");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), {PinholeIntrinsics{5, 5, 2, 2}, 1000.0}),
              HasError("poses_new.json", "so has poses.json beside it"));
}

TEST_F(PosesByName, MayHaveFilesOfTheirOwnInNumPy) {
  const std::vector<double> by_rows = {1, 0, 0, 5, 0, 0, -1, 6, 0, 1, 0, 7, 0, 0, 0, 1};
  const std::vector<double> by_columns = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 5, 6, 7, 1};
  folder_.write("pose/2.npy", npy_array("(4, 4)", by_rows));
  folder_.write("pose/10.npy", npy_array("(4, 4)", by_columns, true));
  EXPECT_EQ(x_of_views(), (std::vector<int>{5, 5}));
  folder_.write("pose/10.npy",
                npy_array("(4, 4)", std::vector<double>(16, std::nan(""))));  // Lost.
  EXPECT_EQ(x_of_views(), (std::vector<int>{5, -1}));
}

TEST_F(PosesByName, FilesThatShouldHaveThemAreNamed) {
  folder_.write("poses.txt", "1 2 3 4 5 6\n1 2 3 4 5 6\n");
  std::vector<std::string> notes;
  EXPECT_EQ(x_of_views(&notes), (std::vector<int>{-1, -1}));
  EXPECT_THAT(notes, Contains(HasSubstr("poses.txt: is not read")));
}

TEST_F(PosesByName, ATrajectoryGoesFirst) {
  folder_.write("poses.json", "[" + rows(1) + ", " + rows(2) + "]");
  folder_.write("trajectory.txt", "3 0 0 0 0 0 1\n4 0 0 0 0 0 1\n");
  EXPECT_EQ(x_of_views(), (std::vector<int>{3, 4}));
}

TEST_F(PosesByName, TimesMayHaveOtherUnits) {
  folder_.write("depth.txt", "0.1 depth/2.png\n0.2 depth/10.png\n");
  std::vector<std::string> notes;
  folder_.write("groundtruth.txt", "100 3 0 0 0 0 0 1\n200 4 0 0 0 0 0 1\n");
  EXPECT_EQ(x_of_views(&notes), (std::vector<int>{3, 4}));
  EXPECT_THAT(notes, Contains(HasSubstr("times of the trajectory are taken as milliseconds")));
  folder_.write("groundtruth.txt", "0.1 3 0 0 0 0 0 1\n0.2 4 0 0 0 0 0 1\n");
  folder_.write("depth.txt", "100000000 depth/2.png\n200000000 depth/10.png\n");
  EXPECT_EQ(x_of_views(&notes), (std::vector<int>{3, 4}));
  EXPECT_THAT(notes, Contains(HasSubstr("times of the depth maps are taken as nanoseconds")));
  // One that agrees is chance: the poses are in the order of the maps.
  folder_.write("groundtruth.txt", "0.2 3 0 0 0 0 0 1\n500 4 0 0 0 0 0 1\n");
  folder_.write("depth.txt", "100 depth/2.png\n200 depth/10.png\n");
  EXPECT_EQ(x_of_views(&notes), (std::vector<int>{3, 4}));
  // At one moment in any smaller unit: that they lie next to the first pose says nothing.
  folder_.write("groundtruth.txt", "0 3 0 0 0 0 0 1\n200 4 0 0 0 0 0 1\n300 4 0 0 0 0 0 1\n");
  folder_.write("depth.txt", "7 depth/2.png\n8 depth/10.png\n");
  const auto spec = read_rgbd_folder(folder_.path(), {PinholeIntrinsics{5, 5, 2, 2}, 1000.0});
  EXPECT_THAT(spec, HasError("3 poses for 2 views", "none within 0.02 s"));
}

TEST_F(PosesByName, ListsMayBeOfAnotherMachine) {
  folder_.write("groundtruth.txt", "1 3 0 0 0 0 0 1\n2 4 0 0 0 0 0 1\n");
  for (const char* list :
       {"1 depth\\2.png\n2 depth\\10.png\n", "1 /home/a/b/depth/2.png\n2 /home/a/b/depth/10.png\n",
        "1 C:\\b\\depth\\2.png\n2 C:\\b\\depth\\10.png\n"}) {
    folder_.write("depth.txt", list);
    EXPECT_EQ(x_of_views(), (std::vector<int>{3, 4})) << list;
  }
}

}  // namespace
}  // namespace relief
