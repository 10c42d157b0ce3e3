#include "scan/io/project/guess/folder_guess.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/files/atomic_file.h"
#include "scan/io/images/image_io.h"
#include "scan/io/project/json/spec_json_private.h"
#include "tests/scan/io/small_files.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::TemporaryFolder;

std::string depth_png(float nearest = 1000.0f) {
  Image image(12, 9, 1, 65535);
  for (std::size_t i = 0; i < image.samples.size(); ++i)
    image.samples[i] = nearest + static_cast<float>(i % 12) + static_cast<float>(i / 12);
  return *encode_png(image);
}

TEST(FolderGuess, PutsImagesOfOneViewTogether) {
  const TemporaryFolder folder;
  for (const char* name : {"owl_01_depth.png", "owl_02_depth.png", "owl_01_normals.png",
                           "owl_01_mask.png", "owl_02_RGB.png", "notes_mask.png"})
    folder.write(name, depth_png());
  const auto guess = value_of(guess_project(folder / "."));
  ASSERT_EQ(guess.project.views.size(), 2u);
  const ViewSpec &first = guess.project.views[0], &second = guess.project.views[1];
  EXPECT_EQ(first.depth->file.filename(), "owl_01_depth.png");
  EXPECT_EQ(first.normals->file.filename(), "owl_01_normals.png");
  EXPECT_EQ(first.mask->file.filename(), "owl_01_mask.png");
  EXPECT_FALSE(first.colour);
  EXPECT_EQ(second.colour->file.filename(), "owl_02_RGB.png");
  EXPECT_EQ(first.camera->width, 12);
  EXPECT_DOUBLE_EQ(first.camera->intrinsics.cx, 5.5);
  EXPECT_THAT(guess.findings, ::testing::Contains(HasSubstr("notes_mask.png")));
  EXPECT_THAT(guess.missing, ::testing::Contains(HasSubstr("fx and fy")));
}

TEST(FolderGuess, FindsRolesInNamesOfFolders) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "Depth Maps");
  std::filesystem::create_directories(folder / "normal");
  folder.write("Depth Maps/a7.png", depth_png());
  folder.write("normal/a7.png", depth_png());
  const auto guess = value_of(guess_project(folder / "."));
  ASSERT_EQ(guess.project.views.size(), 1u);
  EXPECT_TRUE(guess.project.views[0].normals);
}

TEST(FolderGuess, EachViewMayHaveAFolderOfItsOwn) {
  const TemporaryFolder folder;
  for (const char* view : {"view_2", "view_10"}) {
    std::filesystem::create_directories(folder / view);
    folder.write(std::string(view) + "/depth.png", depth_png());
    folder.write(std::string(view) + "/normal.png", depth_png());
  }
  folder.write("view_2/pose.txt", "1 0 0 5\n0 0 -1 6\n0 1 0 7\n0 0 0 1\n");
  folder.write("view_10/pose.txt", "1 0 0 5\n");
  const auto guess = value_of(guess_project(folder / "."));
  ASSERT_EQ(guess.project.views.size(), 2u);
  const ViewSpec &first = guess.project.views[0], &second = guess.project.views[1];
  EXPECT_EQ(first.name, "view_2");
  EXPECT_TRUE(first.normals);
  EXPECT_EQ(first.world_from_view.translation(), Eigen::Vector3d(5, 6, 7));
  EXPECT_EQ(first.pose, PoseKind::kGuess);
  EXPECT_EQ(second.pose, PoseKind::kAbsent);
  EXPECT_THAT(guess.findings, ::testing::Contains(HasSubstr("view_10/pose.txt")));
  EXPECT_THAT(guess.missing, ::testing::Contains(HasSubstr("the pose of each view")));
  EXPECT_EQ(guess.project.unit, "mm");
  folder.write("view_10/pose.txt", "1 0 0 5\n0 0 -1 6\n0 1 0 7\n0 0 0 1\n");
  const auto scaled = value_of(guess_project(folder / ".", {.depth_scale = 1000.0}));
  EXPECT_THAT(scaled.missing, ::testing::Not(::testing::Contains(HasSubstr("the pose of"))));
  EXPECT_EQ(scaled.project.unit, "m");
  EXPECT_THAT(scaled.findings, ::testing::Contains(HasSubstr("pose of view_10 from")));
}

TEST(FolderGuess, APoseThatIsOfNoViewAloneIsNotTaken) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "masks");
  for (const char* name : {"a_depth.png", "b_depth.png"}) folder.write(name, depth_png());
  folder.write("masks/a_mask.png", depth_png());
  folder.write("pose.txt", "1 0 0 5\n0 0 -1 6\n0 1 0 7\n0 0 0 1\n");
  for (const char* path : {".", ""}) {
    const auto guess = value_of(guess_project(folder / path));
    ASSERT_EQ(guess.project.views.size(), 2u);
    EXPECT_TRUE(guess.project.views[0].mask);
    for (const ViewSpec& view : guess.project.views) EXPECT_EQ(view.pose, PoseKind::kAbsent);
  }
}

TEST(FolderGuess, TheFolderItselfMayTellTheRole) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "depth");
  folder.write("depth/1.png", depth_png());
  folder.write("depth/photo.jpg", "");
  const auto guess = value_of(guess_project(folder / "depth/."));
  ASSERT_EQ(guess.project.views.size(), 1u);
  EXPECT_EQ(guess.project.views[0].depth->file.filename(), "1.png");
}

TEST(FolderGuess, ViewsAreInTheOrderOfTheirNumbers) {
  const TemporaryFolder folder;
  for (const char* name : {"depth_1.png", "depth_2.png", "depth_10.png"})
    folder.write(name, depth_png());
  const auto guess = value_of(guess_project(folder / "."));
  ASSERT_EQ(guess.project.views.size(), 3u);
  EXPECT_EQ(guess.project.views[1].depth->file.filename(), "depth_2.png");
  EXPECT_EQ(guess.project.views[2].depth->file.filename(), "depth_10.png");
}

TEST(FolderGuess, TakesCamerasAndPosesFromAMiddleburyList) {
  const TemporaryFolder folder;
  for (const char* name : {"templeSR0001_depth.png", "templeSR0002_depth.png", "b_depth.png"})
    folder.write(name, depth_png());
  const std::string camera = " 500 0 6 0 510 4 0 0 1 1 0 0 0 1 0 0 0 1 ";
  folder.write("templeSR_par.txt",
               "2\ntempleSR0001.png" + camera + "1 2 3\ntempleSR0002.png" + camera + "0 0 0\n");
  const auto guess = value_of(guess_project(folder / "."));
  ASSERT_EQ(guess.project.views.size(), 3u);
  const ViewSpec &unlisted = guess.project.views[0], &first = guess.project.views[1];
  EXPECT_EQ(unlisted.pose, PoseKind::kAbsent);
  EXPECT_EQ(first.camera->intrinsics.fy, 510.0);
  EXPECT_EQ(first.pose, PoseKind::kGuess);
  EXPECT_EQ(first.world_from_view.translation(), Eigen::Vector3d(-1.0, -2.0, -3.0));
  EXPECT_THAT(guess.findings, ::testing::Contains(HasSubstr("2 images")));
  EXPECT_THAT(guess.missing, ::testing::Contains(HasSubstr("fx and fy"))) << "of b";
}

TEST(FolderGuess, WritesAProjectThatIsReadOnceItIsFilledIn) {
  const TemporaryFolder folder;
  folder.write("a_depth.png", depth_png());
  ReadProjectOptions options;
  auto guess = guess_project(folder / ".", options);
  ASSERT_THAT(guess, IsOk());
  folder.write("scan.json", commented_scan_json(*guess, folder / "."));
  EXPECT_THAT(read_project(folder / "scan.json"), HasError("fx"));

  std::filesystem::remove(folder / "scan.json");
  options.intrinsics = PinholeIntrinsics{50, 50, 5.5, 4};
  guess = guess_project(folder / ".", options);
  ASSERT_THAT(guess, IsOk());
  folder.write("scan.json", commented_scan_json(*guess, folder / "."));
  const auto filled = value_of(read_project(folder / "scan.json"));
  EXPECT_EQ(filled.unit, "m");
  EXPECT_EQ(filled.views[0].sample_count(), 108u);
}

TEST(FolderGuess, TakesWhatCanBeReadAsItIs) {
  const TemporaryFolder folder;
  const RangeView view = testing::render(testing::sphere({0, 0, 10}, 2.0),
                                         Camera::pinhole(24, 18, {40, 40, 11.5, 8.5}));
  ASSERT_THAT(write_project({view}, "mm", folder / ".", {}, {.grids = true}), IsOk());
  std::filesystem::remove(folder / "scan.json");
  const auto guess = value_of(guess_project(folder / "."));
  EXPECT_EQ(guess.project.views.size(), 1u);
  EXPECT_TRUE(guess.missing.empty());
}

TEST(FolderGuess, NamesWhatCannotBeRead) {
  const TemporaryFolder folder;
  folder.write("1_depth.png", depth_png());
  folder.write("2_depth.png", depth_png().substr(0, 60));
  folder.write("3_depth.png", depth_png());
  folder.write("3_mask.png", *encode_png(Image(5, 4, 1, 255)));
  for (const bool with_intrinsics : {false, true}) {
    ReadProjectOptions options;
    if (with_intrinsics) options.intrinsics = PinholeIntrinsics{20, 20, 5.5, 4};
    const auto guess = value_of(guess_project(folder.path(), options));
    ASSERT_EQ(guess.unreadable.size(), 2u);
    EXPECT_THAT(guess.unreadable[0], HasSubstr("view 2: "));
    EXPECT_THAT(guess.unreadable[0], HasSubstr("2_depth.png"));
    EXPECT_THAT(guess.unreadable[1], HasSubstr("3_mask.png: is 5x4 pixels"));
    EXPECT_THAT(guess.findings, Not(Contains(HasSubstr("all of it is read"))));
    EXPECT_THAT(commented_scan_json(guess, folder.path()), HasSubstr("// CANNOT BE READ: view 2"));
  }
}

TEST(FolderGuess, DepthMapsAreReadByTheIntrinsicsGiven) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "depth");
  folder.write("depth/1.png", depth_png());
  folder.write("depth/2.png", depth_png(1100.0f));
  ReadProjectOptions options;
  options.intrinsics = PinholeIntrinsics{20.0, 21.0, 5.0, 4.0};
  const auto assumed = value_of(read_project_spec(folder / "depth", options));
  EXPECT_EQ(assumed.views[0].depth->scale, 0.001);
  EXPECT_THAT(assumed.notes, ::testing::Contains(HasSubstr("--depth-scale")));
  options.depth_scale = 1000.0;
  const auto project = value_of(read_project(folder / "depth", options));
  ASSERT_EQ(project.views.size(), 2u);
  EXPECT_EQ(project.unit, "m");
  EXPECT_EQ(project.views[0].pose, PoseKind::kAbsent);
  EXPECT_NEAR(project.views[0].range(3, 2), 1.005, 1e-9);
  const Ray ray = project.views[0].camera.ray(5, 4);
  EXPECT_TRUE(ray.direction.normalized().isApprox(Eigen::Vector3d::UnitZ()));
  options.depth_scale = 0.001;  // Metres of a value.
  EXPECT_NEAR(value_of(read_project(folder / "depth", options)).views[0].range(3, 2), 1.005, 1e-9);
}

TEST(FolderGuess, SixteenGreyBitsTellDepthMapsWithoutAWord) {
  const TemporaryFolder folder;
  Image photograph(12, 9, 3, 255);
  folder.write("1.png", depth_png());
  folder.write("2.png", depth_png(1100.0f));
  for (const char* name : {"1", "2"})
    folder.write(std::string(name) + "_rgb.png", *encode_png(photograph));
  ReadProjectOptions options;
  options.intrinsics = PinholeIntrinsics{20.0, 21.0, 5.0, 4.0};
  const auto project = value_of(read_project(folder.path(), options));
  ASSERT_EQ(project.views.size(), 2u);
  EXPECT_NEAR(project.views[0].range(3, 2), 1.005, 1e-9);
  EXPECT_FALSE(project.views[0].colours.empty());
}

TEST(FolderGuess, ColoursOfAnotherSizeAreLeftOut) {
  const TemporaryFolder folder;
  folder.write("depth_1.png", depth_png());
  folder.write("rgb_1.png", *encode_png(Image(24, 18, 3, 255)));
  ReadProjectOptions options;
  options.intrinsics = PinholeIntrinsics{20.0, 21.0, 5.0, 4.0};
  const auto project = value_of(read_project(folder.path(), options));
  ASSERT_EQ(project.views.size(), 1u);
  EXPECT_TRUE(project.views[0].colours.empty());
  EXPECT_THAT(project.notes, ::testing::Contains(HasSubstr("rgb_1.png: its size is not that of")));
}

TEST(FolderGuess, TakesTheCalibrationBesideDepthMaps) {
  const TemporaryFolder folder;
  folder.write("depth_1.png", depth_png());
  folder.write("rgb_1.png", *encode_png(Image(12, 9, 3, 255)));
  EXPECT_THAT(read_project(folder.path()), HasError("neither intrinsics nor a layout"));
  folder.write("intrinsics_d435.json", R"({"fx": 20, "fy": 21, "s": 0, "cx": 5, "cy": 4})");
  const auto project = value_of(read_project(folder.path()));
  ASSERT_EQ(project.views.size(), 1u);
  EXPECT_FALSE(project.views[0].colours.empty());
  const Ray ray = project.views[0].camera.ray(5, 4);
  EXPECT_TRUE(ray.direction.normalized().isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_THAT(project.notes, ::testing::Contains(HasSubstr("by the calibration beside them")));
}

// As in a folder with a layout.
TEST(FolderGuess, TakesPosesBesideDepthMapsInTheirOrder) {
  const TemporaryFolder folder;
  for (const char* name : {"depth_2.png", "depth_10.png"}) folder.write(name, depth_png());
  const double half = std::sqrt(0.5);
  folder.write("robot_poses.npy",
               testing::npy_array("(2, 7)", {1, 0, 0, half, 0, 0, half, 2, 0, 0, 0, 0, 0, 1}));
  ReadProjectOptions options;
  options.intrinsics = PinholeIntrinsics{20.0, 21.0, 5.0, 4.0};
  const auto project = value_of(read_project(folder.path(), options));
  ASSERT_EQ(project.views.size(), 2u);
  EXPECT_THAT(project.notes, Contains(HasSubstr("robot_poses.npy")));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(project.views[i].pose, PoseKind::kGuess);
    EXPECT_EQ(project.views[i].world_from_view.translation().x(), static_cast<double>(i + 1));
  }
  const auto guess = value_of(guess_project(folder.path()));
  EXPECT_EQ(guess.project.views[1].world_from_view.translation().x(), 2.0);
}

TEST(FolderGuess, TellsOfPosesBesideDepthMapsThatAreOfOthers) {
  const TemporaryFolder folder;
  for (const char* name : {"depth_2.png", "depth_10.png"}) folder.write(name, depth_png());
  folder.write("trajectory.txt", "0 0 0 0 0 0 1\n1 0 0 0 0 0 1\n2 0 0 0 0 0 1\n");
  ReadProjectOptions options;
  options.intrinsics = PinholeIntrinsics{20.0, 21.0, 5.0, 4.0};
  const auto project = value_of(read_project(folder.path(), options));
  for (const RangeView& view : project.views) EXPECT_EQ(view.pose, PoseKind::kAbsent);
  EXPECT_THAT(project.notes, Contains(HasSubstr("poses are not taken")));
}

TEST(FolderGuess, TellsOfIntrinsicsOfAnotherSize) {
  const TemporaryFolder folder;
  folder.write("depth_1.png", depth_png());
  ReadProjectOptions options;
  options.intrinsics = PinholeIntrinsics{20.0, 21.0, 11.5, 8.0};  // Of 24 x 18 pixels.
  EXPECT_THAT(value_of(read_project(folder.path(), options)).notes,
              ::testing::Contains(HasSubstr("1 of 1 views lie far from the middle")));
  options.intrinsics = PinholeIntrinsics{20.0, 21.0, 5.0, 4.0};
  EXPECT_THAT(value_of(read_project(folder.path(), options)).notes,
              ::testing::Not(::testing::Contains(HasSubstr("principal"))));
}

// Some programs write the largest number where nothing was measured.
TEST(FolderGuess, OneValueFarBehindAllOthersIsNoDepth) {
  const TemporaryFolder folder;
  Image image(12, 9, 1, 65535);
  for (std::size_t i = 0; i < image.samples.size(); ++i)
    image.samples[i] = i % 3 == 0 ? 65535.0f : 1000.0f + static_cast<float>(i);
  folder.write("depth_1.png", *encode_png(image));
  image.samples[0] = 30000.0f;  // A sample lies between.
  folder.write("depth_2.png", *encode_png(image));
  std::ranges::replace(image.samples, 65535.0f, 60000.0f);  // A far wall, perhaps.
  folder.write("depth_3.png", *encode_png(image));
  ReadProjectOptions options;
  options.intrinsics = PinholeIntrinsics{20.0, 21.0, 5.0, 4.0};
  options.depth_scale = 1000.0;
  const auto project = value_of(read_project(folder.path(), options));
  ASSERT_EQ(project.views.size(), 3u);
  EXPECT_EQ(project.views[0].sample_count(), 72u);
  EXPECT_EQ(project.views[1].sample_count(), 73u);
  EXPECT_EQ(project.views[2].sample_count(), 108u);
  EXPECT_THAT(project.notes, ::testing::Contains(HasSubstr("value 65535")));
}

TEST(FolderGuess, SaysThatNothingIsAScan) {
  const TemporaryFolder folder;
  folder.write("letter.doc", "x");
  EXPECT_THAT(guess_project(folder / "."), HasError("no file in it can be a scan"));
}

// What a view's entry says is read back as the same entry.
TEST(ViewJson, IsReadBack) {
  const TemporaryFolder folder;
  ViewSpec view;
  view.name = "a";
  view.grid = folder / "scans/a.e57";
  view.grid_options = {2, Eigen::Vector3d(1, 2, 3), true};
  view.camera = CameraSpec{};
  view.camera->model = CameraSpec::Model::kSpherical;
  view.camera->width = 3;
  view.camera->height = 2;
  view.camera->angles = {{0.1, 0.25, 0.3}, {0.5, 0.25}};
  view.normals = NormalSpec{folder / "n.png", NormalEncoding::kRgb, NormalAxes::kOpengl, {}};
  view.mask = ImageFile{folder / "m.png"};
  view.deviation = DeviationSpec{folder / "d.tiff", 0.5};
  view.samples = SampleOrigin::kRefined;
  view.world_from_view.translation() = Eigen::Vector3d(0.1, 0.2, 0.3);
  view.pose = PoseKind::kKnown;
  auto document = empty_project_json("m");
  document["views"].push_back(view_json(view, folder / "."));
  const auto read =
      value_of(parse_scan_json("// a comment\n" + document.dump(), folder / "scan.json"));
  EXPECT_EQ(view_json(read.views[0], folder / "."), document["views"][0]);
  EXPECT_NEAR(read.views[0].camera->angles.azimuth[1], 0.25, 1e-15);
}

}  // namespace
}  // namespace relief
