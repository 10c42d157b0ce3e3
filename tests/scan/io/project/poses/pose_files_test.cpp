#include "scan/io/project/poses/pose_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/files/atomic_file.h"
#include "scan/io/project/view_spec.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;

// Three views of a sphere at poses whose numbers no short decimal holds.
ScanProject three_views() {
  ScanProject project;
  project.unit = "mm";
  for (int i = 0; i < 3; ++i) {
    RangeView view = testing::render(testing::sphere({0, 0, 4}, 1),
                                     Camera::pinhole(24, 20, {30, 30, 11.5, 9.5}));
    view.name = std::to_string(i) + ".25";
    view.world_from_view = Eigen::Translation3d(i / 3.0, 1e3 / 7.0, -1e-3 / 9.0) *
                           Eigen::AngleAxisd(0.1 + i, Eigen::Vector3d(1, 2, 3).normalized());
    view.pose = PoseKind::kGuess;
    project.views.push_back(std::move(view));
  }
  return project;
}

double largest_difference(const ScanProject& a, const ScanProject& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.views.size(); ++i)
    largest = std::max(largest,
                       (a.views[i].world_from_view.matrix() - b.views[i].world_from_view.matrix())
                           .cwiseAbs()
                           .maxCoeff());
  return largest;
}

class PoseFiles : public ::testing::Test {
 protected:
  PoseFiles() { EXPECT_TRUE(write_project(project_, grids(), {}, {.grids = true})); }

  std::filesystem::path grids() const { return folder_.path() / "grids"; }
  std::filesystem::path source() const { return grids() / "scan.json"; }
  std::string text_of(const std::string& file) const {
    EXPECT_TRUE(write_pose_file(project_, source(), {}, folder_.path() / file));
    return read_file(folder_.path() / file).value();
  }

  const ScanProject project_ = three_views();
  TemporaryFolder folder_;
};

TEST_F(PoseFiles, PosesSurviveMeshLabAndStanfordFiles) {
  for (const char* file : {"poses.aln", "poses.conf"}) {
    text_of(file);
    const auto read = value_of(read_project(folder_.path() / file));
    ASSERT_EQ(read.views.size(), project_.views.size());
    EXPECT_LT(largest_difference(read, project_), 1e-12) << file;
    EXPECT_EQ(read.views[1].sample_count(), project_.views[1].sample_count());
  }
}

TEST_F(PoseFiles, TrajectoriesHoldEveryDigit) {
  const std::string log = text_of("poses.log");
  EXPECT_THAT(log, HasSubstr("2 2 3\n"));
  EXPECT_THAT(log, HasSubstr("142.85714285714286"));
  const std::string tum = text_of("poses.tum");
  EXPECT_THAT(tum, HasSubstr("\n1.25 0.33333333333333331 142.85714285714286 "));
}

TEST_F(PoseFiles, ImagesAreNoRangeGrids) {
  const auto images = folder_.path() / "images";
  ASSERT_TRUE(write_project(project_, images));
  EXPECT_THAT(write_pose_file(project_, images / "scan.json", {}, folder_.path() / "poses.aln"),
              HasError("relief convert --grids"));
}

TEST(MeshLabAln, ReadsNamesAndMatrices) {
  const auto spec = value_of(parse_meshlab_aln(
      "2\r\na b.ply\r\n#\r\n1 0 0 5\r\n0 1 0 6\r\n0 0 1 7\r\n0 0 0 1\r\nc.ply\n#\n0 -1 0 0\n1 0 0 "
      "0\n0 0 1 0\n0 0 0 1\n0\n",
      "d/x.aln"));
  ASSERT_EQ(spec.views.size(), 2u);
  EXPECT_EQ(*spec.views[0].grid, "d/a b.ply");
  EXPECT_EQ(spec.views[0].world_from_view.translation(), Eigen::Vector3d(5, 6, 7));
  EXPECT_NEAR(spec.views[1].world_from_view.linear()(1, 0), 1.0, 1e-15);
}

TEST(MeshLabAln, ErrorsNameTheLine) {
  const auto error = [](const std::string& text) { return parse_meshlab_aln(text, "x.aln"); };
  EXPECT_THAT(error("mesh\n"), HasError("x.aln: line 1: expected the number"));
  EXPECT_THAT(error("1\na.ply\n"), HasError("the file ends"));
  EXPECT_THAT(error("1\na.ply\n1 0 0 0\n"), HasError("line 3: expected a line with #"));
  EXPECT_THAT(error("1\na.ply\n#\n1 0 0\n"), HasError("line 4: expected a row"));
  EXPECT_THAT(error("1\na.ply\n#\n2 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"), HasError("line 7"));
  EXPECT_THAT(error("1000000000\na.ply\n"), HasError("the file ends"));
}

}  // namespace
}  // namespace relief
