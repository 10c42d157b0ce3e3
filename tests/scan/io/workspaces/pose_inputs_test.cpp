#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/files/atomic_file.h"
#include "scan/io/workspaces/meshlab_mlp.h"
#include "scan/io/workspaces/middlebury_par.h"
#include "scan/io/workspaces/pose_beside.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_data.h"

namespace relief {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

std::string mlp(const std::string& meshes) {
  return "<!DOCTYPE MeshLabDocument>\n<MeshLabProject>\n <MeshGroup>\n" + meshes +
         " </MeshGroup>\n <RasterGroup/>\n</MeshLabProject>\n";
}

std::string mesh(const std::string& file, const std::string& matrix) {
  return "<MLMesh label=\"x\" filename=\"" + file + "\">\n<MLMatrix44>" + matrix +
         "</MLMatrix44>\n</MLMesh>\n";
}

TEST(MeshLabMlp, ReadsBothNumberLayouts) {
  const auto spec = value_of(
      parse_meshlab_mlp(mlp(mesh("a &amp; b.ply", "\n1 0 0 5 \n0 0 -1 6 \n0 1 0 7 \n0 0 0 1 \n") +
                            mesh("sub/c.ply", "\n1 0 0 5 0 0 -1 6 0 1 0 7 0 0 0 1 \n") +
                            mesh("/x/d.ply", "1 0 0 5 0 0 -1 6 0 1 0 7 0 0 0 1 and words") +
                            "<MLMesh filename=\"e.ply\"/>"),
                        "d/x.mlp"));
  ASSERT_EQ(spec.views.size(), 4u);
  EXPECT_EQ(*spec.views[0].grid, "d/a & b.ply");
  EXPECT_EQ(*spec.views[2].grid, "/x/d.ply");
  for (int i = 0; i < 3; ++i) {
    const auto& motion = spec.views[static_cast<std::size_t>(i)].world_from_view;
    EXPECT_EQ(motion.translation(), Eigen::Vector3d(5, 6, 7));
    EXPECT_NEAR(motion.linear()(2, 1), 1.0, 1e-15);
  }
  EXPECT_EQ(spec.views[3].pose, PoseKind::kAbsent);
}

TEST(MeshLabMlp, ErrorsNameTheLine) {
  const auto parse = [](const std::string& text) { return parse_meshlab_mlp(text, "x.mlp"); };
  const std::string identity = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  EXPECT_THAT(parse("<a"), HasError("x.mlp: line 1: not valid XML"));
  EXPECT_THAT(parse("<a/>"), HasError("no MeshLabProject"));
  EXPECT_THAT(parse(mlp("")), HasError("no MLMesh"));
  EXPECT_THAT(parse(mlp(mesh("", identity))), HasError("line 4: an MLMesh has no filename"));
  EXPECT_THAT(parse(mlp(mesh("a.ply", "1 0 0"))), HasError("line 5: expected sixteen numbers"));
  EXPECT_THAT(parse(mlp(mesh("a.ply", identity + " 3"))), HasError("expected sixteen numbers"));
  EXPECT_THAT(
      parse(mlp(mesh("a.ply", identity) + mesh("b/a.ply", identity) + mesh("c/a.ply", identity))),
      HasError("a second mesh is named a.ply"));
}

// MeshLab's glueing may scale a mesh. Its matrix is no pose, and the other meshes keep theirs.
TEST(MeshLabMlp, AMatrixWithAScaleIsLeftOut) {
  const auto spec =
      value_of(parse_meshlab_mlp(mlp(mesh("a.ply", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1") +
                                     mesh("b.ply", "1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1")),
                                 "x.mlp"));
  ASSERT_EQ(spec.views.size(), 2u);
  EXPECT_EQ(spec.views[0].pose, PoseKind::kAbsent);
  EXPECT_EQ(spec.views[1].pose, PoseKind::kGuess);
  EXPECT_THAT(spec.notes, ElementsAre(AllOf(HasSubstr("view a: taken without a pose"),
                                            HasSubstr("line 5: the matrix of a"),
                                            HasSubstr("not a rigid motion"))));
}

TEST(MeshLabMlp, RealProjects) {
  RELIEF_REQUIRE_TEST_DATA(folder, "formats/meshlab");
  const auto sample = value_of(
      parse_meshlab_mlp(read_file(folder / "sample_project.mlp").value(), folder / "x.mlp"));
  EXPECT_EQ(sample.views.size(), 2u);
  EXPECT_TRUE(std::filesystem::exists(*sample.views[1].grid));
  const auto plant =
      value_of(parse_meshlab_mlp(read_file(folder / "plant.mlp").value(), folder / "x.mlp"));
  EXPECT_EQ(plant.views.at(0).name, "fused");
}

const char* const kMatrix = "1 0 0 5\n0 0 -1 6\n0 1 0 7\n0 0 0 1\n";

TEST(PoseBeside, FindsItsFile) {
  for (const char* name : {"bun000.xf", "bun000.mat.txt", "bun000.matrix.txt", "bun000_matrix.txt",
                           "bun000_REGISTRATION_MATRIX_2020-01-01_10h_00.txt", "bun000.txt"}) {
    const TemporaryFolder folder;
    EXPECT_FALSE(pose_beside(folder / "bun000.ply").value());
    folder.write(name, kMatrix);
    const auto pose = value_of(pose_beside(folder / "bun000.ply"));
    ASSERT_TRUE(pose) << name;
    EXPECT_EQ((pose)->translation(), Eigen::Vector3d(5, 6, 7));
    EXPECT_FALSE(pose_beside(folder / "bun001.ply").value());
  }
}

TEST(PoseBeside, OtherTextsAreNoPoses) {
  const TemporaryFolder folder;
  const auto text = folder.write("a.txt", "1 2 3\n4 5 6\n");
  EXPECT_FALSE(pose_beside(folder / "a.ply").value());
  folder.write("a.txt", kMatrix);
  EXPECT_FALSE(pose_beside(text).value());  // The scan itself.
}

TEST(PoseBeside, ErrorsNameTheLine) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& content) {
    folder.write("a.xf", content);
    return pose_beside(folder / "a.ply");
  };
  EXPECT_THAT(read("1 0 0 0\n0 1 0\n"), HasError("a.xf: line 2: expected a row of four numbers"));
  EXPECT_THAT(read("1 0 0 0\n"), HasError("a.xf: the file ends"));
  EXPECT_THAT(read("1 0 0 0\n0 2 0 0\n0 0 1 0\n0 0 0 1\n"),
              HasError("line 4: the pose is not a rigid motion"));
  EXPECT_THAT(read(std::string(kMatrix) + "1 2 3\n"), HasError("line 5"));
  EXPECT_THAT(read(std::string(5000, ' ')), HasError("larger"));
  std::filesystem::remove(folder / "a.xf");
  folder.write("a_REGISTRATION_MATRIX_1.txt", kMatrix);
  folder.write("a_REGISTRATION_MATRIX_2.txt", kMatrix);
  EXPECT_THAT(pose_beside(folder / "a.ply"),
              HasError("a_REGISTRATION_MATRIX_2.txt: is a second matrix of a"));
}

TEST(MiddleburyPar, ReadsCameras) {
  const auto cameras = value_of(parse_middlebury_par(
      "1\ntemple0001.png 1520.4 0 302.32 0 1525.9 246.87 0 0 1 1 0 0 0 0 1 0 -1 0 1 2 3\n", "t"));
  EXPECT_EQ(cameras.at(0).file, "temple0001.png");
  EXPECT_EQ(cameras.at(0).intrinsics.cy, 246.87);
  EXPECT_TRUE(cameras.at(0).world_from_view.translation().isApprox(Eigen::Vector3d(-1, 3, -2)));
}

TEST(MiddleburyPar, ErrorsNameTheLine) {
  const auto parse = [](const std::string& text) {
    return parse_middlebury_par(text, "t_par.txt");
  };
  EXPECT_THAT(parse(""), HasError("the file ends"));
  EXPECT_THAT(parse("x\n"), HasError("t_par.txt: line 1: expected the number"));
  EXPECT_THAT(parse("1\na.png 1 2 3\n"), HasError("line 2: expected 'name k11"));
  EXPECT_THAT(parse("1\na 1 0 0 0 1 0 0 0 1 1 0 0 0 2 0 0 0 1 0 0 0\n"),
              HasError("line 2: [R t] of a", "not a rigid motion"));
  EXPECT_THAT(parse("1\na 1 9 0 0 1 0 0 0 1 1 0 0 0 1 0 0 0 1 0 0 0\n"), HasError("skew"));
  EXPECT_THAT(parse("1\na 0 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 0 1 0 0 0\n"), HasError("must not be 0"));
  EXPECT_THAT(parse("2\na 1 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 0 1 0 0 0\n"), HasError("the file ends"));
}

}  // namespace
}  // namespace relief
