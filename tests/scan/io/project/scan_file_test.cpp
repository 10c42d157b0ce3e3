#include "scan/io/project/scan_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/io/project_io.h"
#include "scan/io/clouds/files/ptx_file.h"
#include "scan/io/e57/e57_file.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/grids/pcd_grid_writer.h"
#include "scan/io/grids/ply_grid_writer.h"
#include "tests/support/parameter_names.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;

RangeView ball_view(const std::string& name, double x, double radius = 2.0) {
  RangeView view = testing::render(testing::sphere({0, 0, 10}, radius),
                                   Camera::pinhole(40, 30, {60, 60, 19.5, 14.5}));
  view.name = name;
  view.pose = PoseKind::kGuess;
  view.world_from_view.translation().x() = x;
  return view;
}

std::string xyz_text(const RangeView& view) {
  std::string text;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const Eigen::Vector3d p = view.point(u, v);
      text +=
          std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
    }
  }
  return text;
}

void expect_same_points(const RangeView& read, const RangeView& view, double tolerance) {
  ASSERT_EQ(read.sample_count(), view.sample_count());
  std::vector<Eigen::Vector3d> left, right;
  const auto collect = [](const RangeView& from, std::vector<Eigen::Vector3d>& points) {
    for (int v = 0; v < from.height(); ++v)
      for (int u = 0; u < from.width(); ++u)
        if (from.has_sample(u, v)) points.push_back(from.point(u, v));
  };
  collect(read, left);
  collect(view, right);
  const auto by_place = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(left.begin(), left.end(), by_place);
  std::sort(right.begin(), right.end(), by_place);
  for (std::size_t i = 0; i < left.size(); ++i) ASSERT_LT((left[i] - right[i]).norm(), tolerance);
}

class ScanFileInCapitals : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Endings, ScanFileInCapitals, ::testing::Values("PLY", "Pcd"),
                         testing::PrintedName());

TEST_P(ScanFileInCapitals, IsAGridStill) {
  const TemporaryFolder folder;
  const RangeView view = ball_view("a", 1.0);
  const auto path = folder.write(
      "A." + GetParam(), GetParam() == "PLY" ? encode_ply_grid(view) : encode_pcd_grid(view));
  EXPECT_EQ(kind_of_scan_file(path), ScanFileKind::kGrid);
  const auto grid = value_of(read_scan_file(path));
  EXPECT_EQ(grid.points.width(), view.width());
  EXPECT_EQ(grid.points.height(), view.height());
}

TEST(ScanFile, ProjectsMayEndInCapitals) {
  const TemporaryFolder folder;
  folder.write("a.ply", encode_ply_grid(ball_view("a", 1.0)));
  const std::string rows = "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n";
  for (const char* name : {"A.ALN", "A.Conf"}) {
    const auto path =
        folder.write(name, name == std::string("A.ALN") ? "1\na.ply\n#\n" + rows + "0\n"
                                                        : "bmesh a.ply 5 6 7 0 0 0 1\n");
    const auto project = value_of(read_project(path));
    ASSERT_EQ(project.views.size(), 1u) << name;
    EXPECT_EQ(project.views[0].world_from_view.translation(), Eigen::Vector3d(5, 6, 7)) << name;
  }
}

class ScanFileWithTwoScans : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Endings, ScanFileWithTwoScans, ::testing::Values("ptx", "e57"),
                         testing::PrintedName());

TEST_P(ScanFileWithTwoScans, HasAViewForEach) {
  const TemporaryFolder folder;
  const auto path = folder / ("two." + GetParam());
  const std::vector<RangeView> views{ball_view("a", 1.0), ball_view("b", 2.0)};
  ASSERT_THAT(GetParam() == "ptx" ? write_ptx(views, path) : write_e57(views, path), IsOk());
  const auto project = value_of(read_project(path));
  ASSERT_EQ(project.views.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(project.views[i].name, "two-" + std::to_string(i + 1));
    EXPECT_EQ(project.views[i].pose, PoseKind::kGuess);
    EXPECT_TRUE(project.views[i].world_from_view.isApprox(views[i].world_from_view, 1e-12));
    expect_same_points(project.views[i], views[i], 1e-9);
  }
}

TEST(ScanFile, PosesOfFilesCanBeIgnored) {
  const TemporaryFolder folder;
  ASSERT_THAT(write_ptx({ball_view("a", 1.0)}, folder / "a.ptx"), IsOk());
  ReadProjectOptions options;
  options.ignore_viewpoints = true;
  const auto project = value_of(read_project(folder / "a.ptx", options));
  EXPECT_EQ(project.views[0].pose, PoseKind::kAbsent);
}

// A cloud of its own without a viewpoint, one with a viewpoint, and a grid with a pose.
void write_project_of_files(const TemporaryFolder& folder) {
  std::string points;
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j)
      points += std::to_string(0.1 * i) + " " + std::to_string(0.1 * j) + " 4\n";
  folder.write("points.xyz", points);
  ASSERT_THAT(write_ptx({ball_view("posed", 1.0)}, folder / "posed.ptx"), IsOk());
  folder.write("scan.json",
               R"({"format": "relief-scan", "version": 1, "views": [)"
               R"({"name": "open", "grid": {"file": "points.xyz"}},)"
               R"({"name": "told", "grid": {"file": "points.xyz", "viewpoint": [0, 0, 1]}},)"
               R"({"name": "posed", "grid": {"file": "posed.ptx"}}]})");
}

TEST(ScanFile, OptionsApplyToFilesThatAProjectNames) {
  const TemporaryFolder folder;
  write_project_of_files(folder);
  const Eigen::Vector3d viewpoint(0.0, 0.5, 0.0);
  const ReadProjectOptions options{.viewpoint = viewpoint, .ignore_viewpoints = true};
  const auto spec = value_of(read_project_spec(folder / "scan.json", options));
  EXPECT_EQ(spec.views[0].grid_options.viewpoint, viewpoint);
  EXPECT_EQ(spec.views[1].grid_options.viewpoint, Eigen::Vector3d(0.0, 0.0, 1.0));
  EXPECT_THAT(spec.notes, ::testing::ElementsAre(
                              ::testing::HasSubstr("--viewpoint is not used for 1 of 3 views")));
  const auto project = value_of(read_project(folder / "scan.json", options));
  EXPECT_TRUE(project.views[0].camera.ray(3, 3).origin.isApprox(viewpoint));
  EXPECT_EQ(project.views[2].pose, PoseKind::kAbsent);
}

// Else the aligned views are read without the options, from another side.
TEST(ScanFile, OptionsAreWrittenWithThePoses) {
  const TemporaryFolder folder;
  write_project_of_files(folder);
  const ReadProjectOptions options{.viewpoint = Eigen::Vector3d::Zero(), .ignore_viewpoints = true};
  const auto project = value_of(read_project(folder / "scan.json", options));
  ASSERT_THAT(write_project_poses(project, folder / "scan.json", options, folder / "aligned.json"),
              IsOk());
  const auto aligned = value_of(read_project_spec(folder / "aligned.json", {}));
  EXPECT_EQ(aligned.views[0].grid_options.viewpoint, Eigen::Vector3d::Zero().eval());
  EXPECT_EQ(aligned.views[1].grid_options.viewpoint, Eigen::Vector3d(0.0, 0.0, 1.0));
  EXPECT_TRUE(aligned.views[2].grid_options.ignore_pose);
}

TEST(ScanFile, OptionsThatNoViewNeedsAreNamed) {
  const TemporaryFolder folder;
  ASSERT_THAT(write_project({{ball_view("a", 1.0)}}, "mm", folder.path()), IsOk());
  folder.write("fc.txt", "500 500 32 32");
  const auto spec = value_of(
      read_project_spec(folder.path(), {.fc_file = folder / "fc.txt",
                                        .intrinsics = PinholeIntrinsics{500.0, 500.0, 32.0, 32.0},
                                        .depth_scale = 1000.0,
                                        .viewpoint = Eigen::Vector3d::Zero().eval(),
                                        .ignore_viewpoints = true}));
  for (const char* option : {"--fc is", "--intrinsics are", "--depth-scale is", "--viewpoint is"})
    EXPECT_THAT(spec.notes,
                ::testing::Contains(::testing::HasSubstr(std::string(option) + " not used")));
}

// The same ball in one frame, from two sides.
TEST(ScanFile, FilesWithoutPosesCanShareAFrame) {
  const TemporaryFolder folder;
  const auto write_half = [&](const char* name, double side) {
    std::string text;
    for (int i = 0; i < 40; ++i) {
      for (int j = 0; j < 40; ++j) {
        const double x = 0.04 * (i - 19.5), y = 0.04 * (j - 19.5);
        if (x * x + y * y < 0.6)
          text += std::to_string(5.0 + x) + " " + std::to_string(y) + " " +
                  std::to_string(side * std::sqrt(1.0 - x * x - y * y)) + "\n";
      }
    }
    folder.write(name, text);
  };
  write_half("front.xyz", 1.0);
  write_half("back.xyz", -1.0);
  const auto unknown = value_of(read_project(folder.path()));
  EXPECT_THAT(unknown.notes, ::testing::Contains(::testing::HasSubstr("give --shared-frame")));
  const auto shared = value_of(read_project(folder.path(), {.shared_frame = true}));
  ASSERT_EQ(shared.views.size(), 2u);
  for (const RangeView& view : shared.views) {
    EXPECT_EQ(view.pose, PoseKind::kGuess);
    EXPECT_TRUE(view.world_from_view.isApprox(RigidMotion::Identity(), 0.0));
  }
  EXPECT_THAT(shared.notes,
              ::testing::Not(::testing::Contains(::testing::HasSubstr("--shared-frame"))));
}

TEST(ScanFile, ASharedFrameNeedsFilesOfScans) {
  const TemporaryFolder folder;
  ASSERT_THAT(write_project({{ball_view("a", 1.0)}}, "mm", folder.path()), IsOk());
  EXPECT_THAT(read_project(folder.path(), {.shared_frame = true}),
              HasError("--shared-frame is for files of points"));
}

TEST(ScanFile, KindFollowsFromTheHeader) {
  const TemporaryFolder folder;
  const RangeView view = ball_view("a", 0.0);
  EXPECT_EQ(kind_of_scan_file(folder.write("a.ply", encode_ply_grid(view))), ScanFileKind::kGrid);
  EXPECT_EQ(kind_of_scan_file(folder.write("a.pcd", encode_pcd_grid(view))), ScanFileKind::kGrid);
  EXPECT_EQ(kind_of_scan_file(folder.write("a.XYZ", "1 2 3\n")), ScanFileKind::kPoints);
  EXPECT_EQ(kind_of_scan_file(folder.write("b.ply", "ply\nend_header\n")), ScanFileKind::kPoints);
  EXPECT_EQ(kind_of_scan_file(folder.write("a.doc", "")), ScanFileKind::kNone);
}

TEST(ScanFile, ThereIsNoSecondScanInAFileOfOne) {
  const TemporaryFolder folder;
  EXPECT_THAT(
      read_scan_file(folder.write("a.ply", encode_ply_grid(ball_view("a", 0.0))), {.scan = 1}),
      HasError("holds one scan"));
}

TEST(ScanFile, AMatrixThatIsNoMotionIsAppliedAndNamed) {
  const TemporaryFolder folder;
  std::string text = "2\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n2 0 0 0\n0 2 0 0\n0 0 2 0\n5 0 0 1\n";
  for (const char* point : {"0 0 1", "1 0 1", "0 1 1", "1 1 1"})
    text += std::string(point) + " 0.5\n";
  const auto project = value_of(read_project(folder.write("a.ptx", text)));
  EXPECT_THAT(project.notes, ::testing::Contains(HasSubstr("the matrix was applied")));
  double largest = 0.0;
  for (int v = 0; v < 2; ++v)
    for (int u = 0; u < 2; ++u) largest = std::max(largest, project.views[0].point(u, v).x());
  EXPECT_NEAR(largest, 7.0, 1e-12);
}

TEST(ScanFile, AFewPointsAreAView) {
  const TemporaryFolder folder;
  const auto project = value_of(read_project(folder.write("a.xyz", "1 2 3\n4 5 6\n7 8 10\n")));
  EXPECT_EQ(project.views[0].sample_count(), 3u);
}

TEST(ScanFile, AFolderOfPointsIsAProject) {
  const TemporaryFolder folder;
  const RangeView view = ball_view("a", 0.0);
  folder.write("a.xyz", xyz_text(view));
  folder.write("b.xyz", xyz_text(ball_view("b", 0.0, 1.9)));
  const auto project = value_of(read_project(folder / "."));
  ASSERT_EQ(project.views.size(), 2u);
  EXPECT_GT(project.views[0].sample_count(), view.sample_count() * 9 / 10);
  EXPECT_TRUE(project.views[0].camera.can_project());
  EXPECT_THAT(project.notes, ::testing::Contains(HasSubstr("points and meshes without")));
}

// Such files may be anything: they are points where they begin so and nothing else is there.
TEST(ScanFile, AFolderOfPlainTextIsAProject) {
  const TemporaryFolder folder;
  const std::string points = "x y z\n" + xyz_text(ball_view("a", 0.0));
  folder.write("scan_2.csv", points);
  folder.write("scan_10.csv", "x y z\n" + xyz_text(ball_view("b", 0.0, 1.9)));
  folder.write("notes.txt", std::string(2000, 'n'));
  const auto project = value_of(read_project(folder / "."));
  ASSERT_EQ(project.views.size(), 2u);
  EXPECT_EQ(project.views[0].name, "scan_2");
  folder.write("third.xyz", points);
  EXPECT_EQ(value_of(read_project(folder / ".")).views.size(), 1u);
}

// As pcl_normal_estimation and its like write normals, without their points.
TEST(ScanFile, AFolderMayHoldPcdsWithoutPoints) {
  const TemporaryFolder folder;
  const auto pcd = [](const std::string& fields, const std::string& values) {
    return "VERSION 0.7\nFIELDS " + fields +
           "\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
           "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n" +
           values;
  };
  folder.write("a.pcd", pcd("x y z", "1 2 3\n4 5 6\n"));
  folder.write("a_normal.pcd", pcd("normal_x normal_y normal_z", "0 0 1\n0 0 1\n"));
  const auto project = value_of(read_project(folder.path()));
  ASSERT_EQ(project.views.size(), 1u);
  EXPECT_EQ(project.views[0].name, "a");
  EXPECT_THAT(project.notes, Contains(HasSubstr("a_normal.pcd: it holds no points")));
}

TEST(ScanFile, GridsGoBeforePoints) {
  const TemporaryFolder folder;
  folder.write("a.ply", encode_ply_grid(ball_view("a", 0.0)));
  folder.write("b.xyz", xyz_text(ball_view("a", 0.0)));
  const auto project = value_of(read_project(folder / "."));
  EXPECT_EQ(project.views.size(), 1u);
  EXPECT_THAT(project.notes, ::testing::Contains(HasSubstr("b.xyz")));
}

// A scanner that turns round its axis is found in the points of its file, and kept by a project.
TEST(ScanFile, ASphericalScannerIsFoundAndKept) {
  const TemporaryFolder folder;
  RangeView view;
  view.name = "station";
  view.camera = Camera::spherical(
      SphericalProjection::even(120, 50, 3.1, -2.0 * 3.14159265358979 / 120, 0.8, -0.03));
  view.range = Grid<double>(120, 50, kNoSample);
  for (int v = 0; v < 50; ++v)
    for (int u = 0; u < 120; ++u) {
      // A box of 5 x 4 x 3 round the scanner.
      const Eigen::Vector3d d = view.camera.ray(u, v).direction.cwiseAbs();
      view.range(u, v) = std::min({2.5 / d.x(), 2.0 / d.y(), 1.5 / d.z()});
    }
  ASSERT_THAT(write_ptx({view}, folder / "a.ptx"), IsOk());
  const auto project = value_of(read_project(folder / "a.ptx"));
  EXPECT_EQ(project.views[0].camera.model(), Camera::Model::kSpherical);
  ASSERT_THAT(write_project(project, folder / "out"), IsOk());
  const auto again = value_of(read_project(folder / "out"));
  EXPECT_EQ(again.views[0].camera.model(), Camera::Model::kSpherical);
  for (int v = 0; v < 50; ++v)
    for (int u = 0; u < 120; ++u)
      ASSERT_LT((again.views[0].point(u, v) - project.views[0].point(u, v)).norm(), 1e-9);
}

}  // namespace
}  // namespace relief
