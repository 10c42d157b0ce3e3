#include "relief/io/project_io.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/files/atomic_file.h"
#include "scan/io/grids/pcd_grid_writer.h"
#include "scan/io/grids/ply_grid_writer.h"
#include "scan/io/images/image_io.h"
#include "scan/io/project/loading/view_loader.h"
#include "tests/support/geometry_matchers.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::render;
using testing::sphere;
using testing::TemporaryFolder;

const PinholeIntrinsics kIntrinsics{60, 62, 23.5, 17.5};

// One view of each kind of camera.
ScanProject all_cameras() {
  ScanProject project;
  project.unit = "m";
  const Camera gl = Camera::pinhole_gl(48, 36, kIntrinsics);
  const Camera parallel = Camera::orthographic(40, 40, {-1, -1, 1}, {0.05, 0, 0}, {0, 0.05, 0},
                                               -Eigen::Vector3d::UnitZ());
  RationalProjection line_scanner{{40, 0, 0, 20}, {0, 0, 0, 1}, {0, 200, -20, 100}, {0, 0, -1, 5}};
  Grid<Ray> rays(40, 40);
  for (int v = 0; v < 40; ++v)
    for (int u = 0; u < 40; ++u) rays(u, v) = line_scanner.ray(u, v, -Eigen::Vector3d::UnitZ());
  project.views = {render(sphere({0, 0, 0}, 2), Camera::pinhole(48, 36, kIntrinsics),
                          testing::look_at({8, 1, 2}, {0, 0, 0})),
                   render(sphere({0, 0, -7}, 2), gl), render(sphere({0, 0, 0}, 0.79), parallel),
                   render(sphere({0, 0, 0}, 0.39), Camera::ray_table(rays, line_scanner))};
  const char* names[] = {"pinhole", "gl", "parallel", "line scanner/1"};
  for (std::size_t i = 0; i < 4; ++i) project.views[i].name = names[i];
  project.views[0].pose = PoseKind::kKnown;
  project.views[2].pose = PoseKind::kAbsent;
  project.views[1].samples = project.views[3].samples = SampleOrigin::kRefined;
  for (auto& view : project.views) {
    view.confidence = Grid<float>(view.width(), view.height(), 0.25f);
    view.deviation = Grid<float>(view.width(), view.height(), 0.125f);
    view.deviation(view.width() / 2, view.height() / 2) = static_cast<float>(kNoSample);
    view.deviation(view.width() / 3, view.height() / 2) = std::numeric_limits<float>::infinity();
    view.colours = Grid<Colour>(view.width(), view.height());
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        view.colours(u, v) = {static_cast<std::uint8_t>(5 * u), static_cast<std::uint8_t>(6 * v),
                              200};
    view.normals(view.width() / 2, view.height() / 2).setConstant(static_cast<float>(kNoSample));
  }
  return project;
}

void expect_same_view(const RangeView& read, const RangeView& written) {
  SCOPED_TRACE(written.name);
  EXPECT_EQ(read.name, written.name);
  EXPECT_EQ(read.pose, written.pose);
  EXPECT_EQ(read.samples, written.samples);
  EXPECT_TRUE(read.world_from_view.isApprox(written.world_from_view, 1e-14));
  ASSERT_EQ(read.width(), written.width());
  ASSERT_EQ(read.height(), written.height());
  ASSERT_EQ(read.sample_count(), written.sample_count());
  ASSERT_EQ(read.has_normals(), written.has_normals());
  ASSERT_EQ(read.colours.empty(), written.colours.empty());
  for (int v = 0; v < read.height(); ++v) {
    for (int u = 0; u < read.width(); ++u) {
      ASSERT_EQ(read.has_sample(u, v), written.has_sample(u, v));
      if (!read.has_sample(u, v)) continue;
      const Eigen::Vector3d p = written.point(u, v);
      ASSERT_NEAR((read.point(u, v) - p).norm(), 0.0, 1e-6 * (1.0 + p.norm()));
      ASSERT_EQ(read.confidence_at(u, v), written.confidence_at(u, v));
      ASSERT_EQ(read.deviation_at(u, v) > 0.0f, written.deviation_at(u, v) > 0.0f);
      if (written.deviation_at(u, v) > 0.0f) {
        ASSERT_EQ(read.deviation_at(u, v), written.deviation_at(u, v));
      }
      if (!written.colours.empty()) {
        ASSERT_EQ(read.colours(u, v), written.colours(u, v));
      }
      if (!written.has_normals()) continue;
      ASSERT_EQ(read.has_normal(u, v), written.has_normal(u, v)) << u << " " << v;
      if (read.has_normal(u, v)) {
        ASSERT_NEAR((read.normals(u, v) - written.normals(u, v)).norm(), 0, 1e-6);
      }
      const Eigen::Vector3d d = written.camera.ray(u, v).direction.normalized();
      ASSERT_NEAR((read.camera.ray(u, v).direction.normalized() - d).norm(), 0.0, 1e-6);
    }
  }
}

TEST(ProjectIo, WhatIsWrittenIsReadBackForEveryCamera) {
  const TemporaryFolder folder;
  const ScanProject project = all_cameras();
  for (const auto& view : project.views) ASSERT_GT(view.sample_count(), 100u) << view.name;
  ASSERT_THAT(write_project(project, folder / "sub/out"), IsOk());
  const auto read = value_of(read_project(folder / "sub/out/scan.json"));
  EXPECT_EQ(read.unit, "m");
  ASSERT_EQ(read.views.size(), project.views.size());
  for (std::size_t i = 0; i < project.views.size(); ++i)
    expect_same_view(read.views[i], project.views[i]);
  EXPECT_THAT(read_project(folder / "sub/out"), IsOk()) << "a folder with a scan.json";
  EXPECT_TRUE(read.views[3].camera.can_project());
}

TEST(ProjectIo, AllCamerasMayBeWrittenAsGrids) {
  const TemporaryFolder folder;
  const ScanProject project = all_cameras();
  ASSERT_THAT(write_project(project, folder.path(), {}, {.grids = true}), IsOk());
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(name.ends_with(".ply") || name.ends_with("_deviation.tiff") || name == "scan.json")
        << name;
  }
  const auto read = value_of(read_project(folder.path()));
  for (std::size_t i = 0; i < project.views.size(); ++i)
    expect_same_view(read.views[i], project.views[i]);
}

TEST(ProjectIo, AllCamerasMayBeWrittenAsPcd) {
  const TemporaryFolder folder;
  const ScanProject project = all_cameras();
  ASSERT_THAT(
      write_project(project, folder.path(), {}, {.grids = true, .grid_format = GridFormat::kPcd}),
      IsOk());
  EXPECT_TRUE(std::filesystem::exists(folder / "pinhole.pcd"));
  const auto read = value_of(read_project(folder.path()));
  for (std::size_t i = 0; i < project.views.size(); ++i)
    expect_same_view(read.views[i], project.views[i]);
}

TEST(ProjectIo, APcdAloneKeepsItsPoseAsAGuess) {
  const TemporaryFolder folder;
  const RangeView written = all_cameras().views[0];
  const auto read = value_of(read_project(folder.write("a.pcd", encode_pcd_grid(written))));
  EXPECT_EQ(read.views[0].pose, PoseKind::kGuess);
  EXPECT_TRUE(read.views[0].world_from_view.isApprox(written.world_from_view, 1e-6));
  EXPECT_EQ(read.views[0].camera.model(), Camera::Model::kPinhole);
}

TEST(ProjectIo, WritingTwiceGivesTheSameBytes) {
  const TemporaryFolder folder;
  ASSERT_THAT(write_project(all_cameras(), folder / "a"), IsOk());
  ASSERT_THAT(write_project(all_cameras(), folder / "b"), IsOk());
  for (const auto& entry : std::filesystem::directory_iterator(folder / "a"))
    EXPECT_EQ(*read_file(entry.path()), *read_file(folder / "b" / entry.path().filename()));
}

TEST(ProjectIo, ParallelDepthMapsBehindTheirOriginAreKept) {
  const TemporaryFolder folder;
  ScanProject project;
  const Camera camera = Camera::orthographic(20, 20, {-1, -1, 0}, {0.1, 0, 0}, {0, 0.1, 0},
                                             -Eigen::Vector3d::UnitZ());
  project.views = {render(sphere({0, 0, 0}, 0.9), camera)};
  project.views[0].normals = {};
  ASSERT_LT(project.views[0].range(10, 10), 0.0);
  ASSERT_THAT(write_project(project, folder.path()), IsOk());
  const auto read = value_of(read_project(folder.path()));
  EXPECT_NEAR((read.views[0].point(10, 10) - project.views[0].point(10, 10)).norm(), 0, 1e-6);
}

TEST(ProjectIo, UnwritablePlacesAreErrors) {
  EXPECT_THAT(write_project(all_cameras(), "/proc/relief"), HasError(ErrorKind::kCannotWrite));
}

TEST(ProjectIo, AFolderOfGridsReadsPosesBesideThem) {
  const TemporaryFolder folder;
  const RangeView view = render(sphere({0, 0, 9}, 3), Camera::pinhole(48, 36, kIntrinsics));
  folder.write("b.ply", encode_ply_grid(view));
  folder.write("a.ply", encode_ply_grid(view));
  folder.write("a.xf", "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n");
  folder.write("mesh.ply",
               "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n");
  const auto project = value_of(read_project(folder.path()));
  ASSERT_EQ(project.views.size(), 2u);
  EXPECT_EQ(project.views[0].name, "a");
  EXPECT_EQ(project.views[0].world_from_view.translation(), Eigen::Vector3d(5, 6, 7));
  EXPECT_EQ(project.views[1].pose, PoseKind::kAbsent);
  EXPECT_EQ(project.views[0].camera.model(), Camera::Model::kPinhole);
  EXPECT_THAT(project.notes.at(0), HasSubstr("mesh.ply"));
  folder.write("b.xf", "1 0 0 5\n0 1 0 6\n");
  EXPECT_THAT(read_project(folder.path()), HasError());
}

TEST(ProjectIo, AnFcFileGivesTheIntrinsics) {
  const TemporaryFolder folder;
  const RangeView view = render(sphere({0, 0, -9}, 3), Camera::pinhole_gl(48, 36, kIntrinsics));
  const auto grid = folder.write("a.ply", encode_ply_grid(view));
  const auto read = [&](const std::string& text) {
    return read_project(grid, {.fc_file = folder.write("a.fc", text)});
  };
  const auto project = value_of(read("60 62 23.5 17.5\n"));
  EXPECT_EQ(project.views[0].camera.model(), Camera::Model::kPinholeGl);
  EXPECT_EQ(project.views[0].camera.intrinsics().fy, 62);
  EXPECT_THAT(project.notes, IsEmpty());
  const auto of_folder = value_of(read_project(folder.path(), {.fc_file = folder / "a.fc"}));
  EXPECT_EQ(of_folder.views[0].camera.intrinsics().fy, 62);
  EXPECT_THAT(read("60 62 23.5\n"), HasError());
  EXPECT_THAT(read("0 62 23.5 17\n"), HasError());
  EXPECT_THAT(read("60 62 23.5 x\n"), HasError());
}

// A project of one depth map on disk, whose parts tests replace.
class DepthProject : public ::testing::Test {
 protected:
  void SetUp() override {
    Image depth(8, 6, 1, 65535);
    for (std::size_t i = 0; i < depth.samples.size(); ++i)
      depth.samples[i] = static_cast<float>(1000 + i);
    depth(0, 0) = 0;
    folder_.write("d.png", *encode_png(depth));
  }

  Result<ScanProject> read(const std::string& more = "", const std::string& file = "d.png",
                           const std::string& kind = "z") const {
    return read_project(folder_.write(
        "scan.json",
        R"({"format":"relief-scan","version":1,"views":[{"name":"v7","depth":{"file":")" + file +
            R"(","scale":0.01,"kind":")" + kind +
            R"("},"camera":{"model":"pinhole","width":8,"height":6,"fx":5,"fy":5,"cx":4,"cy":3})" +
            more + "}]}"));
  }

  TemporaryFolder folder_;
};

TEST_F(DepthProject, ScalesDepthAndLeavesZeroOut) {
  const auto project = value_of(read());
  const RangeView& view = project.views[0];
  EXPECT_FALSE(view.has_sample(0, 0));
  EXPECT_NEAR(view.point(1, 0).z(), 10.01, 1e-12);
  EXPECT_EQ(view.pose, PoseKind::kAbsent);
  const auto along = read("", "d.png", "ray");
  EXPECT_NEAR(along->views[0].point(1, 0).norm(), 10.01, 1e-12);
}

// ICL-NUIM trajectories come with fy = -480: y points up, against the rows.
TEST_F(DepthProject, ANegativeFocalLengthTurnsTheAxisRound) {
  const auto path = folder_.write(
      "scan.json",
      R"({"format":"relief-scan","version":1,"views":[{"name":"v7","depth":{"file":"d.png","scale":0.01},)"
      R"("camera":{"model":"pinhole","width":8,"height":6,"fx":5,"fy":-5,"cx":4,"cy":3}}]})");
  const auto project = value_of(read_project(path));
  const auto upright = value_of(read());
  const Eigen::Vector3d point = project.views[0].point(6, 1);
  const Eigen::Vector3d mirrored(1, -1, 1);
  EXPECT_THAT(point, IsNear(upright.views[0].point(6, 1).cwiseProduct(mirrored), 1e-12));
  EXPECT_GT(point.y(), 0.0);
}

TEST_F(DepthProject, ValuesThatAreNoDepthAreNoSamples) {
  Image depth(8, 6, 1);
  depth.samples.assign(depth.samples.size(), 5.0f);
  depth(1, 1) = -5.0f;
  depth(2, 1) = std::numeric_limits<float>::quiet_NaN();
  depth(3, 1) = std::numeric_limits<float>::infinity();
  folder_.write("f.tiff", *encode_tiff(depth));
  const auto project = value_of(read("", "f.tiff"));
  EXPECT_EQ(project.views[0].sample_count(), 45u);
  EXPECT_FALSE(project.views[0].has_sample(2, 1));
}

TEST_F(DepthProject, MasksAndConfidencesApply) {
  Image mask(8, 6, 1, 255), confidence(8, 6, 1, 255);
  mask(3, 3) = 1;
  mask(4, 3) = 255;
  confidence(3, 3) = 255;
  folder_.write("m.png", *encode_png(mask));
  folder_.write("c.png", *encode_png(confidence));
  const auto project = value_of(read(R"(,"mask":{"file":"m.png"},"confidence":{"file":"c.png"})"));
  EXPECT_EQ(project.views[0].sample_count(), 2u);
  EXPECT_EQ(project.views[0].confidence_at(3, 3), 1.0f);
  EXPECT_EQ(project.views[0].confidence_at(4, 3), 0.0f);
}

// A camera that measures normals sees what the range sensor misses. Masked pixels are no object.
TEST_F(DepthProject, NormalsStayWhereTheRangeIsMissing) {
  Image normals(8, 6, 3), depth(8, 6, 1), mask(8, 6, 1, 255);
  for (int v = 0; v < 6; ++v) {
    for (int u = 0; u < 8; ++u) {
      normals(u, v, 2) = -1.0f;
      depth(u, v) = u == 3 ? 0.0f : 1000.0f;
      mask(u, v) = v == 5 ? 0.0f : 255.0f;
    }
  }
  folder_.write("n.tiff", *encode_tiff(normals));
  folder_.write("f.tiff", *encode_tiff(depth));
  folder_.write("m.png", *encode_png(mask));
  const auto project = value_of(read(
      R"(,"mask":{"file":"m.png"},"normals":{"file":"n.tiff","encoding":"unit","axes":"opencv","space":"camera"})",
      "f.tiff"));
  const RangeView& view = project.views[0];
  EXPECT_FALSE(view.has_sample(3, 2));
  EXPECT_TRUE(view.has_normal(3, 2));
  EXPECT_TRUE(view.has_normal(2, 2));
  EXPECT_FALSE(view.has_normal(2, 5));
}

TEST_F(DepthProject, DeviationsAreScaledUnknownWhereNotPositiveAndMayBeInfinite) {
  Image deviation(8, 6, 1);
  deviation.samples.assign(deviation.samples.size(), 5.0f);
  deviation(1, 1) = -5.0f;
  deviation(2, 1) = std::numeric_limits<float>::quiet_NaN();
  deviation(3, 1) = 0.0f;
  deviation(4, 1) = std::numeric_limits<float>::infinity();
  folder_.write("s.tiff", *encode_tiff(deviation));
  Image depth(8, 6, 1);
  depth.samples.assign(depth.samples.size(), 10.0f);
  depth(5, 5) = 0.0f;
  folder_.write("f.tiff", *encode_tiff(depth));
  const auto project = value_of(read(R"(,"deviation":{"file":"s.tiff","scale":0.01})", "f.tiff"));
  const RangeView& view = project.views[0];
  EXPECT_NEAR(view.deviation_at(4, 4), 0.05, 1e-8);
  EXPECT_EQ(view.deviation_at(4, 1), std::numeric_limits<float>::infinity());
  for (const auto& [u, v] : {std::pair{1, 1}, {2, 1}, {3, 1}, {5, 5}})
    EXPECT_TRUE(std::isnan(view.deviation_at(u, v))) << u << " " << v;
}

TEST_F(DepthProject, ColoursComeFromImagesOfIntegers) {
  Image rgb(8, 6, 3, 65535), grey(8, 6, 1, 255);
  rgb(2, 1, 0) = 65535;
  rgb(2, 1, 2) = 257;
  grey(2, 1) = 77;
  folder_.write("rgb.png", *encode_png(rgb));
  folder_.write("grey.png", *encode_png(grey));
  const auto coloured = value_of(read(R"(,"color":{"file":"rgb.png"})"));
  EXPECT_EQ(coloured.views[0].colours(2, 1), (Colour{255, 0, 1}));
  EXPECT_EQ(read(R"(,"color":{"file":"grey.png"})")->views[0].colours(2, 1), (Colour{77, 77, 77}));
  EXPECT_TRUE(read()->views[0].colours.empty());
  folder_.write("small.png", *encode_png(Image(7, 6, 3, 255)));
  folder_.write("float.tiff", *encode_tiff(Image(8, 6, 3)));
  EXPECT_THAT(read(R"(,"color":{"file":"small.png"})"), HasError("small.png: is 7x6"));
  EXPECT_THAT(read(R"(,"color":{"file":"float.tiff"})"), HasError("image of integers"));
  EXPECT_THAT(read(R"(,"color":"rgb.png")"), HasError("color"));
}

TEST_F(DepthProject, AViewWithoutSamplesIsNamed) {
  folder_.write("m.png", *encode_png(Image(8, 6, 1, 255)));
  folder_.write("empty.png", *encode_png(Image(8, 6, 1, 65535)));
  for (const auto& project : {read(R"(,"mask":{"file":"m.png"})"), read("", "empty.png")}) {
    EXPECT_THAT(project, HasError(ErrorKind::kUnsolvable, "view v7 has no samples"));
  }
}

TEST_F(DepthProject, SizesThatDifferAreNamedWithBothFiles) {
  folder_.write("n.png", *encode_png(Image(7, 6, 3, 255)));
  EXPECT_THAT(read(R"(,"normals":{"file":"n.png"})"),
              HasError("n.png: is 7x6", "d.png of the same view is 8x6"));
  folder_.write("big.png", *encode_png(Image(9, 6, 1, 65535)));
  EXPECT_THAT(read("", "big.png"), HasError("is 9x6, but the camera of view v7 is 8x6"));
}

TEST_F(DepthProject, MissingAndUnsuitableFilesAreNamed) {
  EXPECT_THAT(read("", "missing.png"), HasError("missing.png"));
  Image rgb(8, 6, 3, 255);
  rgb(2, 1, 0) = 7.0f;
  folder_.write("rgb.png", *encode_png(rgb));
  EXPECT_THAT(read("", "rgb.png"), HasError("one channel"));
  EXPECT_THAT(read(R"(,"mask":{"file":"none.png"})"), HasError("none.png"));
}

TEST(ProjectIo, DamagedFilesAreAllNamedAndCanBeLeftOut) {
  const TemporaryFolder folder;
  const std::string grid =
      "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 2\n"
      "element vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement range_grid 4\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 -9\n1 0 -9\n0 1 -9\n1 1 -9\n1 0\n1 1\n1 2\n1 3\n";
  folder.write("a.ply", grid);
  folder.write("b.ply", grid.substr(0, grid.size() - 30));
  std::string other = grid;
  other.replace(other.find("0 0 -9"), 6, "0 0 -8");
  folder.write("c.ply", other);
  EXPECT_THAT(read_project(folder.path()), HasError(ErrorKind::kBadInput, "b.ply"));
  EXPECT_THAT(read_project(folder.path()), HasError("--skip-damaged goes on without it"));
  folder.write("d.ply", grid.substr(0, grid.size() - 20));
  EXPECT_THAT(read_project(folder.path()),
              HasError(ErrorKind::kBadInput, "2 of 4 views cannot be read; --skip-damaged"));
  EXPECT_THAT(read_project(folder.path()), HasError(ErrorKind::kBadInput, "d.ply"));
  const auto rest = value_of(read_project(folder.path(), {.skip_damaged = true}));
  EXPECT_EQ(rest.views.size(), 2u);
  EXPECT_THAT(rest.notes, Contains(HasSubstr("a view is left out: ")));
  EXPECT_THAT(rest.notes, Contains(HasSubstr("d.ply")));
  folder.write("a.ply", grid.substr(0, grid.size() - 20));
  folder.write("c.ply", grid.substr(0, grid.size() - 20));
  EXPECT_THAT(read_project(folder.path(), {.skip_damaged = true}), HasError());
}

TEST_F(DepthProject, ProgressCanStopReading) {
  const auto path = folder_ / "scan.json";
  ASSERT_THAT(read(), IsOk());
  Context context{.threads = 1};
  context.progress = [](double, std::string_view) { return false; };
  const auto stopped = read_project(path, {}, context);
  // The only view was read before anybody could stop.
  EXPECT_THAT(stopped, AnyOf(IsOk(), HasError(ErrorKind::kInterrupted)));
}

TEST_F(DepthProject, PosesAreWrittenIntoACopyThatRefersToTheSameFiles) {
  auto project = value_of(read(R"(,"pose_is":"guess","world_from_view":)"
                               R"([[1,0,0,1],[0,1,0,2],[0,0,1,3],[0,0,0,1]])"));
  project.views[0].world_from_view.translation() << 7, 8, 9;
  project.views[0].pose = PoseKind::kKnown;
  std::filesystem::create_directory(folder_ / "results");
  const auto file = folder_ / "results/aligned.json";
  ASSERT_THAT(write_project_poses(project, folder_ / "scan.json", {}, file), IsOk());
  EXPECT_THAT(*read_file(file), HasSubstr("../d.png"));
  const auto again = value_of(read_project(file));
  EXPECT_EQ(again.views[0].world_from_view.translation(), Eigen::Vector3d(7, 8, 9));
  EXPECT_EQ(again.views[0].pose, PoseKind::kKnown);
  EXPECT_EQ(again.views[0].range(4, 4), project.views[0].range(4, 4));
}

TEST(ProjectIo, PosesOfGridFilesGetAProjectFile) {
  const TemporaryFolder folder;
  const RangeView view = render(sphere({0, 0, -9}, 3), Camera::pinhole_gl(48, 36, kIntrinsics));
  const auto grid = folder.write("a.ply", encode_ply_grid(view));
  const ReadProjectOptions options{.fc_file = folder.write("a.fc", "60 62 23.5 17.5\n")};
  auto project = value_of(read_project(grid, options));
  project.views[0].world_from_view.translation() << 1, 2, 3;
  project.views[0].pose = PoseKind::kGuess;
  ASSERT_THAT(write_project_poses(project, grid, options, folder / "aligned.json"), IsOk());
  const auto again = value_of(read_project(folder / "aligned.json"));
  EXPECT_EQ(again.views[0].camera.model(), Camera::Model::kPinholeGl);
  EXPECT_EQ(again.views[0].world_from_view.translation(), Eigen::Vector3d(1, 2, 3));
}

TEST(ProjectIo, WhatIsNoProjectIsNamed) {
  const TemporaryFolder folder;
  for (const auto& path :
       {folder / "missing", folder.path(), folder.write("a.txt", ""), folder.write("b.json", "")}) {
    EXPECT_THAT(read_project(path), HasError(ErrorKind::kBadInput, path.string()));
  }
}

TEST(ProjectIo, ImagesWithoutACameraNameTheWayOn) {
  const TemporaryFolder folder;
  folder.write("depth_000.png", "");
  folder.write("depth_001.PNG", "");
  EXPECT_THAT(read_project(folder.path()),
              HasError("holds images (2), but neither intrinsics", "relief init",
                       "--intrinsics FX FY CX CY --depth-scale N"));
}

TEST(ProjectIo, AFolderAboveImagesNamesTheirs) {
  const TemporaryFolder folder;
  EXPECT_THAT(read_project(folder.path()), HasError("name the folder that holds these"));
  folder.write("configs/roi.json", "{}");
  folder.write("images/depth_0.png", "");
  folder.write("images/depth_1.png", "");
  EXPECT_THAT(read_project(folder.path()),
              HasError("its folder images holds images (2): name that", "relief init"));
}

// A file that belongs to a project, without being one, says what to give in its place.
TEST(ProjectIo, PartsOfProjectsNameTheRemedy) {
  const TemporaryFolder folder;
  const auto error = [&](const char* name, const char* content) {
    return read_project(folder.write(name, content));
  };
  EXPECT_THAT(error("a.log", "0 0 1\n"), HasError("a.log: holds poses", "name the folder"));
  EXPECT_THAT(error("a.fc", "5 5 1 1\n"), HasError("give it as --fc"));
  EXPECT_THAT(error("a.PNG", ""), HasError("is an image without a camera; 'relief init FOLDER'"));
  EXPECT_THAT(error("a.laz", ""), HasError("export it as E57, PTX or XYZ text"));
  EXPECT_THAT(error("a.glb", ""), HasError("only written"));
  EXPECT_THAT(error("camera.json", R"({"intrinsic_matrix": [5,0,0, 0,5,0, 2,1,1]})"),
              HasError("camera.json: belongs to depth maps; name the folder"));
  EXPECT_THAT(error("groundtruth.txt", "# truth\ntime tx ty tz qx qy qz qw\n1 0 0 0 0 0 0 1\n"),
              HasError("groundtruth.txt: belongs to depth maps"));
  EXPECT_THAT(error("a.foo", ""), HasError("unknown project format '.foo'"));
  EXPECT_THAT(error("scan.json", "{}"), HasError("a project begins with \"format\""));
}

TEST(ProjectIo, ManyViewsOfOneFileAreBoundByTheMemory) {
  const TemporaryFolder folder;
  Image depth(64, 64, 1, 65535);
  for (float& sample : depth.samples) sample = 1000.0f;
  folder.write("depth.png", *encode_png(depth));
  std::string views;
  for (int i = 0; i < 50; ++i)
    views += std::string(i > 0 ? "," : "") + R"({"name":")" + std::to_string(i) +
             R"(","depth":{"file":"depth.png"},"camera":{"model":"pinhole","fx":60,"fy":60,)" +
             R"("cx":31.5,"cy":31.5}})";
  const auto path = folder.write(
      "scan.json", R"({"format":"relief-scan","version":1,"unit":"mm","views":[)" + views + "]}");
  constexpr std::size_t kView = 64 * 64 * 20;
  ReadProjectOptions options;
  options.memory = 50 * kView;
  EXPECT_THAT(read_project(path, options), IsOk());
  options.memory = 50 * kView - 1;
  EXPECT_THAT(read_project(path, options),
              HasError(ErrorKind::kUnsolvable, "depth.png: view ", "give fewer or smaller ones"));
}

// Views lie in files then, but each is decoded in memory.
TEST(MemoryBudget, OneViewMayTakeLessThanAllTogether) {
  MemoryBudget budget(100, 40);
  EXPECT_FALSE(budget.take(41));
  EXPECT_EQ(budget.left(), 40u);
  EXPECT_TRUE(budget.take(40));
  EXPECT_TRUE(budget.take(40));
  EXPECT_FALSE(budget.take(40));
  EXPECT_EQ(budget.left(), 20u);
}

TEST(ReadProject, TellsOfScansThatTheOnlyProjectDoesNotName) {
  const TemporaryFolder folder;
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  for (const char* name : {"a.obj", "b.obj", "c.obj"}) folder.write(name, triangle);
  folder.write("all.aln",
               "2\na.obj\n#\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\nb.obj\n#\n1 0 0 0\n"
               "0 1 0 0\n0 0 1 0\n0 0 0 1\n0\n");
  const auto spec = value_of(read_project_spec(folder.path()));
  EXPECT_EQ(spec.views.size(), 2u);
  EXPECT_THAT(spec.notes,
              Contains(HasSubstr("all.aln names; 1 more files of scans are left out, as c.obj")));
}

}  // namespace
}  // namespace relief
