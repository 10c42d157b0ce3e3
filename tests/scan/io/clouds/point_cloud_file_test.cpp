#include "scan/io/clouds/files/point_cloud_file.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/io/mesh_io.h"
#include "relief/scan/triangle_mesh.h"
#include "tests/support/limited_memory.h"
#include "tests/support/parameter_names.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_data.h"

namespace relief {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::LimitedMemory;
using testing::TemporaryFolder;

PointCloudFile parsed(const std::string& content) { return value_of(parse_xyz(content, "a.xyz")); }

auto parse(const std::string& content) { return parse_xyz(content, "a.xyz"); }

TEST(XyzText, ReadsPointsExactly) {
  const auto cloud = parsed("0.1 -2e-3 +3\n\n  1.7976931348623157e308\t4.9e-324 -0\r\n");
  ASSERT_EQ(cloud.points.size(), 2u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3d(0.1, -2e-3, 3));
  EXPECT_EQ(cloud.points[1].x(), 1.7976931348623157e308);
  EXPECT_TRUE(cloud.normals.empty());
  EXPECT_TRUE(cloud.colours.empty());
  EXPECT_THAT(cloud.notes, IsEmpty());
}

TEST(XyzText, LinesMayEndInReturnsAlone) {
  const auto cloud = parsed("x y z\r1 2 3\r4 5 6\r");
  ASSERT_EQ(cloud.points.size(), 2u);
  EXPECT_EQ(cloud.points[1], Eigen::Vector3d(4, 5, 6));
}

TEST(XyzText, KnowsSeparatorsAndComments) {
  for (const char* text :
       {"1,2,3\n4,5,6\n", "1;2;3\n4;5;6", "1, 2, 3\n# end\n4, 5, 6\n",
        "// made by hand\n1\t2\t3\n//\n4 5 6\n", "# x of things\n1 2 3\n4 5 6"}) {
    const auto cloud = parsed(text);
    ASSERT_EQ(cloud.points.size(), 2u) << text;
    EXPECT_EQ(cloud.points[1], Eigen::Vector3d(4, 5, 6)) << text;
  }
}

TEST(XyzText, KnowsTheMarksOfEditors) {
  EXPECT_EQ(parsed("\xef\xbb\xbf"
                   "1 2 3\n")
                .points[0],
            Eigen::Vector3d(1, 2, 3));
  EXPECT_THAT(parse(std::string("\xff\xfe"
                                "1\0 \0",
                                6)),
              HasError("UTF-16 text; save it as UTF-8"));
}

// Read as separators, they would give other points, and colours besides.
TEST(XyzText, RefusesDecimalCommas) {
  for (const char* text : {"1,5 2,3 0,1\n", "1,5;2,3;0,1\n", "0,5\t1\t2\n"})
    EXPECT_THAT(parse(text), HasError("line 1: decimals have commas; write them with a point"))
        << text;
  EXPECT_THAT(parsed("1 2 3 7,8,9\n").colours, ElementsAre(Colour{7, 8, 9}));
}

TEST(XyzText, TellsNormalsFromColours) {
  const auto normals = parsed("1 2 3 0 0.6 0.8\n4 5 6 0 0 -1\n");
  EXPECT_THAT(normals.normals,
              ElementsAre(Eigen::Vector3f(0, 0.6f, 0.8f), Eigen::Vector3f(0, 0, -1)));
  EXPECT_THAT(normals.colours, IsEmpty());
  const auto colours = parsed("1 2 3 0 128 255\n4 5 6 1 2 3\n");
  EXPECT_THAT(colours.colours, ElementsAre(Colour{0, 128, 255}, Colour{1, 2, 3}));
  EXPECT_THAT(colours.normals, IsEmpty());
  EXPECT_THAT(parse("1 2 3 0.5 0.5 0.5\n"), HasError("begin the file with a line of column names"));
  EXPECT_THAT(parse("1 2 3 4 5\n"), HasError("its 5 columns is not clear"));
}

TEST(XyzText, KnowsEveryOrderOfColumns) {
  for (const char* text : {"1 2 3 0 0 1 7 8 9\n", "1 2 3 7 8 9 0 0 1\n", "1 2 3 -5 7 8 9 0 0 1\n",
                           "1 2 3 0 0 1 7 8 9 0.5\n"}) {
    const auto cloud = parsed(text);
    ASSERT_EQ(cloud.normals.size(), 1u) << text;
    EXPECT_EQ(cloud.normals[0], Eigen::Vector3f(0, 0, 1)) << text;
    EXPECT_THAT(cloud.colours, ElementsAre(Colour{7, 8, 9})) << text;
  }
}

TEST(XyzText, NamesWinOverGuesses) {
  for (const char* names : {"X Y Z R G B\n", "//X,Y,Z,R,G,B\n", "# x y z red green blue\n",
                            "\"X\",\"Y\",\"Z\",\"Red\",\"Green\",\"Blue\"\n"}) {
    const auto cloud = parsed(std::string(names) + "1 2 3 0 0 1\n");
    EXPECT_THAT(cloud.colours, ElementsAre(Colour{0, 0, 1})) << names;
    EXPECT_THAT(cloud.normals, IsEmpty()) << names;
  }
  const auto turned = parsed("b,g,r,time,z,y,x\n3,2,1,99,6,5,4\n");
  EXPECT_EQ(turned.points[0], Eigen::Vector3d(4, 5, 6));
  EXPECT_THAT(turned.colours, ElementsAre(Colour{1, 2, 3}));
  const auto real = parsed("x y z r g b\n1 2 3 0.5 0 1\n");
  EXPECT_THAT(real.colours, ElementsAre(Colour{128, 0, 255}));
  const auto normals = parsed("x y z Nx Ny Nz\n1 2 3 3 4 0\n");
  EXPECT_THAT(normals.normals, ElementsAre(Eigen::Vector3f(3, 4, 0)));
}

TEST(XyzText, IntensitiesBecomeGrey) {
  EXPECT_THAT(parsed("1 2 3 0\n1 2 4 1\n1 2 5 0.2\n").colours,
              ElementsAre(Colour{0, 0, 0}, Colour{255, 255, 255}, Colour{51, 51, 51}));
  EXPECT_THAT(parsed("1 2 3 17\n1 2 4 200\n").colours,
              ElementsAre(Colour{17, 17, 17}, Colour{200, 200, 200}));
  EXPECT_THAT(parsed("1 2 3 -2048\n1 2 4 2047\n").colours,
              ElementsAre(Colour{0, 0, 0}, Colour{255, 255, 255}));
  EXPECT_THAT(parsed("1 2 3 4\n1 2 4 4\n").colours, IsEmpty());
}

TEST(XyzText, HoldsPointsAgainstTheirNumber) {
  const auto cloud = parsed("2\n1 2 3 -1613 52 70 64\n4 5 6 -1998 58 76 67\n");
  EXPECT_THAT(cloud.colours, ElementsAre(Colour{52, 70, 64}, Colour{58, 76, 67}));
  EXPECT_EQ(parsed("1\n1 2 3\n2\n4 5 6\n7 8 9\n").points.size(), 3u);
  EXPECT_THAT(parse("5\n1 2 3\n4 5 6\n"),
              HasError("a.xyz: truncated: line 1 promises 5 points, 3 lines are missing"));
  const auto more = parsed("1\n1 2 3\n4 5 6\n");
  EXPECT_EQ(more.points.size(), 2u);
  EXPECT_THAT(more.notes, ElementsAre("line 1 promises 1 points, 2 follow and are read"));
  EXPECT_THAT(parse("1.5\n1 2 3\n"), HasError("line 1: a single number says how many"));
}

TEST(XyzText, LeavesOutWhatIsNotFinite) {
  const auto cloud = parsed("1 2 3 1 2 3\nnan nan nan 4 5 6\n7 8 inf 7 8 9\n4 5 6 9 9 9\n");
  EXPECT_EQ(cloud.points.size(), 2u);
  EXPECT_THAT(cloud.colours, ElementsAre(Colour{1, 2, 3}, Colour{9, 9, 9}));
  EXPECT_THAT(cloud.notes, ElementsAre("2 points that are not finite are left out"));
  EXPECT_THAT(parse("nan nan nan\n"), HasError("no point of the file is finite"));
}

TEST(XyzText, NamesTheLineAndTheRemedy) {
  EXPECT_THAT(parse(""), HasError("a.xyz: no point in the file"));
  EXPECT_THAT(parse("# nothing\n"), HasError("no point in the file"));
  EXPECT_THAT(parse("a cloud of points\n1 2 3\n"),
              HasError("line 1: 'a' is no number; a line of column names has x, y and z"));
  EXPECT_THAT(parse("1 2 3\n\n1 2\n"), HasError("line 3: 2 numbers, but the points before"));
  EXPECT_THAT(parse("1 2 3\n1 2 z\n"), HasError("line 2: 'z' is no number"));
  EXPECT_THAT(parse("1 2\n"), HasError("line 1: a point has at least three numbers"));
  EXPECT_THAT(parse("x y z r\n1 2 3\n"),
              HasError("line 2: 3 numbers, but 4 columns are named before"));
  EXPECT_THAT(parse(",,,\n"), HasError("line 1: no number between"));
  std::string many;
  for (int i = 0; i < 100; ++i) many += "1 ";
  EXPECT_THAT(parse(many), HasError("line 1: more than 64 numbers"));
}

TEST(XyzText, PosesAreNoPoints) {
  const std::string poses = "1 2 3 0.5 0.5 0.5 0.5\n1 2 4 0 0.6 0 0.8\n";
  for (const char* time : {"", "12.5 "}) {
    std::string content;
    for (std::size_t begin = 0; begin < poses.size(); begin = poses.find('\n', begin) + 1)
      content += time + poses.substr(begin, poses.find('\n', begin) + 1 - begin);
    EXPECT_THAT(parse_xyz(content, "a.xyz"), HasError("holds poses"));
  }
  EXPECT_THAT(parse_xyz("1 2 3 0 0 0.6 0.8\n1 2 4 0 0 0 1\n", "a.xyz"), IsOk())
      << "normals behind an intensity of 0";
}

TEST(XyzText, DamagedFilesNeverCrash) {
  const std::string content =
      "3\n//X,Y,Z,R,G,B,Nx,Ny,Nz\n1 2 3 4 5 6 0 0 1\n1,2,3,4,5,6,0,1,0\n1 2 3 255 5 6 1 0 0\n";
  ASSERT_THAT(parse_xyz(content, "a.xyz"), IsOk());
  const LimitedMemory limit(std::size_t{1} << 28);
  for (std::size_t size = 0; size < content.size(); ++size)
    (void)parse_xyz(content.substr(0, size), "a.xyz");
  std::mt19937 random(3);
  for (int k = 0; k < 5000; ++k) {
    std::string changed = content;
    for (std::size_t i = 0; i <= random() % 3; ++i)
      changed[random() % changed.size()] =
          static_cast<char>(random() % 3 ? random() % 256 : '0' + random() % 10);
    (void)parse_xyz(changed, "a.xyz");
  }
}

TEST(PointCloudFile, ReadsRealText) {
  RELIEF_REQUIRE_TEST_DATA(path, "formats/ptx");
  const auto count = [&](const char* name) {
    return value_of(read_point_cloud(path / name)).points.size();
  };
  EXPECT_EQ(count("autzen.pts"), 10u);
  EXPECT_EQ(count("bunny_8.pts"), 9u);
  EXPECT_EQ(count("site_56_8.pts"), 8u);
  EXPECT_EQ(count("test.pts"), 19u);
  EXPECT_EQ(read_point_cloud(path / "test.pts")->colours[0], (Colour{97, 59, 38}));
}

TEST(PointCloudFile, ReadsPlyClouds) {
  const TemporaryFolder folder;
  const auto path = folder.write(
      "a.PLY",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
      "double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float "
      "nx\nproperty float ny\nproperty float nz\nend_header\n1 2 0.1 7 8 9 0 0 1\nnan 0 0 0 0 0 0 "
      "0 0\n4 5 6 1 2 3 0 1 0\n");
  const auto cloud = value_of(read_point_cloud(path));
  EXPECT_THAT(cloud.points, ElementsAre(Eigen::Vector3d(1, 2, 0.1), Eigen::Vector3d(4, 5, 6)));
  EXPECT_THAT(cloud.normals, ElementsAre(Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(0, 1, 0)));
  EXPECT_THAT(cloud.colours, ElementsAre(Colour{7, 8, 9}, Colour{1, 2, 3}));
  EXPECT_THAT(cloud.notes, ElementsAre("1 points that are not finite are left out"));
  EXPECT_THAT(cloud.facing, IsEmpty());
}

TEST(PointCloudFile, LeavesOutSeveralPointsAtTheOrigin) {
  const TemporaryFolder folder;
  const auto several =
      value_of(read_point_cloud(folder.write("several.xyz", "0 0 0\n1 2 3\n0 0 0\n0 0 1\n")));
  EXPECT_THAT(several.points, ElementsAre(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 0, 1)));
  EXPECT_THAT(several.notes, ElementsAre("2 points at the origin are taken for missing samples"));
  const auto one = value_of(read_point_cloud(folder.write("one.xyz", "0 0 0\n1 2 3\n")));
  EXPECT_THAT(one.points, ElementsAre(Eigen::Vector3d::Zero(), Eigen::Vector3d(1, 2, 3)));
  EXPECT_THAT(read_point_cloud(folder.write("none.xyz", "0 0 0\n0 0 0\n")),
              HasError("none.xyz: no point of the file is finite and measured"));
}

TEST(PointCloudFile, LeavesOutPointsThatStandTwice) {
  const TemporaryFolder folder;
  const auto cloud = value_of(read_point_cloud(folder.write(
      "twice.xyz", "x y z r g b\n1 2 3 9 8 7\n4 5 6 1 2 3\n1 2 3 0 0 0\n1 2 3.5 4 4 4\n")));
  EXPECT_THAT(cloud.points, ElementsAre(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, 5, 6),
                                        Eigen::Vector3d(1, 2, 3.5)));
  EXPECT_THAT(cloud.colours, ElementsAre(Colour{9, 8, 7}, Colour{1, 2, 3}, Colour{4, 4, 4}));
  EXPECT_THAT(cloud.notes, ElementsAre("1 points are where others of the file are, and left out"));
}

TEST(PointCloudFile, LeavesOutNormalsThatAreAllZero) {
  const TemporaryFolder folder;
  const std::string header = "x y z nx ny nz\n";
  const auto zero =
      value_of(read_point_cloud(folder.write("zero.xyz", header + "1 2 3 0 0 0\n4 5 6 0 0 0\n")));
  EXPECT_THAT(zero.normals, IsEmpty());
  EXPECT_THAT(zero.notes, ElementsAre("the normals of the file are all zero: not used"));
  const auto some =
      value_of(read_point_cloud(folder.write("some.xyz", header + "1 2 3 0 0 0\n4 5 6 0 0 1\n")));
  EXPECT_EQ(some.normals.size(), 2u);
}

TEST(PointCloudFile, LeavesOutPointsAtAnInvalidDepth) {
  const TemporaryFolder folder;
  // As a depth camera writes 65535 mm: on many rays, at one depth.
  const auto cloud = value_of(read_point_cloud(
      folder.write("camera.xyz", "1 2 3\n-17.9 8 65.535004\n0 1 2.5\n16.8 -20 65.535004\n")));
  EXPECT_THAT(cloud.points, ElementsAre(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 1, 2.5)));
  EXPECT_THAT(cloud.notes, ElementsAre("2 points at the depth 65.535, far behind all others, are "
                                       "taken for missing samples"));
  const auto behind = value_of(read_point_cloud(
      folder.write("opengl.xyz", "1 2 -3\n-17.9 8 -65.535\n0 1 -2.5\n16.8 -20 -65.535\n")));
  EXPECT_EQ(behind.points.size(), 2u);
  const auto wall =
      value_of(read_point_cloud(folder.write("wall.xyz", "1 2 3\n-5 8 9\n0 1 2.5\n6 -2 9\n")));
  EXPECT_EQ(wall.points.size(), 4u) << "others are within a quarter";
}

TEST(PointCloudFile, LeavesOutCornersAtTheLargestDepthOf16Bits) {
  const TemporaryFolder folder;
  const std::string faces = "f 1 2 3\nf 2 4 3\n";
  const auto camera = value_of(read_point_cloud(
      folder.write("camera.obj", "v 1 2 -3\nv 9 8 -65.535\nv 0 1 -40\nv 6 -20 -65.535\n" + faces)));
  EXPECT_EQ(camera.points.size(), 2u);
  EXPECT_THAT(camera.notes, ElementsAre(::testing::HasSubstr("taken for missing samples")));
  const auto box = value_of(read_point_cloud(
      folder.write("box.obj", "v 1 2 -3\nv 9 8 -60\nv 0 1 -4\nv 6 -20 -60\n" + faces)));
  EXPECT_EQ(box.points.size(), 4u);
}

TriangleMesh square() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

class PointCloudOfAMesh : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Endings, PointCloudOfAMesh, ::testing::Values("ply", "obj", "stl", "vtp"),
                         testing::PrintedName());

TEST_P(PointCloudOfAMesh, HasItsVerticesAsPoints) {
  const TemporaryFolder folder;
  const auto path = folder / ("a." + GetParam());
  ASSERT_THAT(write_mesh(square(), path), IsOk());
  const auto cloud = value_of(read_point_cloud(path));
  EXPECT_EQ(cloud.points.size(), 4u);
  ASSERT_EQ(cloud.facing.size(), 4u);
  EXPECT_EQ(cloud.facing[0], Eigen::Vector3f(0, 0, 1));
  EXPECT_THAT(cloud.normals, IsEmpty());
}

TEST(PointCloudFile, ReadsPcdPoints) {
  RELIEF_REQUIRE_TEST_DATA(path, "formats/pcd");
  const auto column = value_of(read_point_cloud(path / "colored_cloud.pcd"));
  EXPECT_EQ(column.points.size(), 1000u);
  EXPECT_EQ(column.colours.size(), 1000u);
  const auto table = value_of(read_point_cloud(path / "table_scene_mug_stereo_textured.pcd"));
  ASSERT_TRUE(table.world_from_view.has_value());
  ASSERT_TRUE(table.viewpoint.has_value());
  EXPECT_TRUE(table.viewpoint->isZero());
}

TEST(PointCloudFile, NamesAnUnknownEnding) {
  const TemporaryFolder folder;
  EXPECT_THAT(read_point_cloud(folder.write("a.las", "1 2 3\n")),
              HasError("a.las: unknown format '.las'"));
  EXPECT_FALSE(has_cloud_ending("a.las"));
  EXPECT_TRUE(has_cloud_ending("a.XYZ"));
  EXPECT_THAT(read_point_cloud(folder / "missing.xyz"), HasError());
}

}  // namespace
}  // namespace relief
