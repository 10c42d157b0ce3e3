#include "scan/io/workspaces/rgbd/rgbd_folder.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/files/atomic_file.h"
#include "scan/io/images/image_io.h"
#include "scan/io/project/loading/view_loader.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/poses/trajectories.h"
#include "tests/scan/io/small_files.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_data.h"

namespace relief {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::png_head;
using testing::TemporaryFolder;

const char* const kPose = "1 0 0 5\n0 0 -1 6\n0 1 0 7\n0 0 0 1\n";
const RgbdOptions kOptions{PinholeIntrinsics{500, -500, 319.5, 239.5}, 1000.0};

TEST(TumLists, UnderstandHeaders) {
  const auto list = value_of(parse_tum_list(
      "# depth maps\n# file: 'a.bag'\ntimestamp filename\n1.5 depth/1.5.png\n2 depth/a b.png\n",
      "depth.txt"));
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list.at(1).file, "depth/a b.png");
  const auto glued =
      parse_tum_list("# timestamp filename1.5 depth/1.5.png\n2 b.png\n", "depth.txt");
  ASSERT_EQ(glued->size(), 2u);
  EXPECT_EQ(glued->at(0).time, 1.5);
  EXPECT_THAT(parse_tum_list("1 a.png\nx b.png\n", "depth.txt"),
              HasError("depth.txt: line 2: expected 'time file'"));
}

TEST(TumLists, AssociationsHaveEitherOrder) {
  const auto pairs = value_of(
      parse_tum_associations("1 rgb/1.png 1.01 depth/1.png\n2 depth/2.png 2 rgb/2.png\n", "a.txt"));
  EXPECT_EQ(pairs.at(0).depth.time, 1.01);
  EXPECT_EQ(pairs.at(1).depth.file, "depth/2.png");
  EXPECT_EQ(pairs.at(1).colour.file, "rgb/2.png");
  EXPECT_THAT(parse_tum_associations("1 a.png 2\n", "a.txt"), HasError("line 1"));
  EXPECT_EQ(kind_of_rgbd_text("1 a.png 1.01 b.png\n"), RgbdText::kAssociations);
  EXPECT_EQ(kind_of_rgbd_text("1 Motion: xyz=0,0,0 rpy=0,0,0\n"), RgbdText::kUnknown);
}

TEST(TumTrajectory, ReadsAPoseBehindTheHeader) {
  for (const char* header : {"# TUM trajectory, format: <t> <x> <y> <z> <qx> <qy> <qz> <qw>",
                             "# timestamp tx ty tz qx qy qz qw",
                             "# TUM trajectory, format: <t> <x> <y> <z> <qx> <qy> <qz> <qw>\n"}) {
    const std::string text =
        std::string(header) + "0.25 1 2 3 0 0 0.6 0.8\n1.25 -1e-3 2 3 0 0 0 1\n";
    EXPECT_EQ(kind_of_rgbd_text(text), RgbdText::kTumPoses) << header;
    const auto trajectory = value_of(parse_tum_trajectory(text, "t.txt"));
    ASSERT_EQ(trajectory.size(), 2u) << header;
    EXPECT_EQ(*trajectory.at(0).time, 0.25);
    EXPECT_NEAR(trajectory.at(0).world_from_view.linear()(1, 0), 0.96, 1e-15);
    EXPECT_EQ(trajectory.at(1).world_from_view.translation().x(), -1e-3);
  }
  // A pose that is commented out is none.
  const auto commented = parse_tum_trajectory("#0.25 1 2 3 0 0 0 1\n", "t.txt");
  EXPECT_TRUE(commented->empty());
}

TEST(TumTrajectory, NumbersMayHaveTwoDecimals) {
  const auto rounded = value_of(parse_tum_trajectory("1 0 0 0 0 0 0.61 0.79\n", "t.txt"));
  EXPECT_NEAR(rounded[0].world_from_view.linear().determinant(), 1.0, 1e-12);
  EXPECT_THAT(parse_tum_trajectory("1 0 0 0 0 0 0.6 0.9\n", "t.txt"), HasError("length 1"));
}

TEST(TumTrajectory, ErrorsNameTheLine) {
  const auto parse = [](const std::string& text) { return parse_tum_trajectory(text, "t.txt"); };
  EXPECT_THAT(parse("# x\n1 0 0 0 0 0 0 2\n"), HasError("t.txt: line 2: not a rigid motion"));
  EXPECT_THAT(parse("1 0 0 0 0 0 0 1\n2 0 0 0 1 1 0 0\n"), HasError("line 2: not a rigid"));
  EXPECT_THAT(parse("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n"), HasError("line 2: the time is before"));
  EXPECT_THAT(parse("2 0 0 0 0 0 0 1\n1 0 0\n"), HasError("line 2: expected 'time tx"));
  EXPECT_THAT(parse("0 0 0 0 0 0 1\n1 0 0\n"), HasError("line 2: expected 'tx ty"));
}

TEST(TumTrajectory, InterpolatesWithinTheTolerance) {
  const auto trajectory =
      parse_tum_trajectory("1 0 0 0 0 0 0 1\n1.01 1 0 0 0 0 0.6 0.8\n2 5 0 0 0 0 0 1\n", "t");
  const auto between = value_of(pose_at(*trajectory, 1.0025, 0.02));
  EXPECT_NEAR(between.translation().x(), 0.25, 1e-9);
  EXPECT_NEAR(rotation_angle(between), 0.25 * 2 * std::asin(0.6), 1e-9);
  EXPECT_NEAR(pose_at(*trajectory, 1.025, 0.02)->translation().x(), 1.0, 1e-15);
  EXPECT_FALSE(pose_at(*trajectory, 1.5, 0.02));
  EXPECT_EQ(pose_at(*trajectory, 2.0, 0.02)->translation().x(), 5.0);
  EXPECT_FALSE(pose_at(*trajectory, 3.0, 0.02));
}

TEST(LogTrajectory, ReadsPosesAndRefusesPairs) {
  const auto trajectory = value_of(parse_log_trajectory(std::string("0 0 1\n") + kPose, "a.log"));
  EXPECT_EQ(trajectory.at(0).world_from_view.translation(), Eigen::Vector3d(5, 6, 7));
  EXPECT_THAT(parse_log_trajectory(std::string("0 1 57\n") + kPose, "a.log"),
              HasError("a.log: line 1: this is a pose of one frame relative to another"));
  EXPECT_THAT(parse_log_trajectory("0 0 1\n1 0 0 0\n0 2 0 0\n0 0 1 0\n0 0 0 1\n", "a"),
              HasError("line 5", "not a rigid motion"));
  EXPECT_THAT(parse_log_trajectory("0 0 1\n1 0 0 0\n", "a"), HasError("the file ends"));
}

TEST(Open3dCamera, IsColumnMajor) {
  const std::string head = R"({"width": 640, "height": 480, "intrinsic_matrix": )";
  const auto camera = value_of(parse_open3d_camera(
      head + "[525, 0, 0, 0, -526, 0, 319.5, 239.5, 1], \"depth_scale\": 1000}", "c.json"));
  EXPECT_EQ(camera.intrinsics->fy, -526);
  EXPECT_EQ(camera.intrinsics->cx, 319.5);
  EXPECT_EQ(*camera.depth_scale, 1000);
  EXPECT_EQ(camera.size->width, 640);
  const auto rows =
      parse_open3d_camera(head + "[525, 0, 319.5, 0, 526, 239.5, 0, 0, 1]}", "c.json");
  EXPECT_EQ(rows->intrinsics->cy, 239.5);
  EXPECT_THAT(parse_open3d_camera(head + "[1, 2]}", "c.json"),
              HasError("c.json: intrinsic_matrix: expected 9 numbers"));
  EXPECT_THAT(parse_open3d_camera(head + "[1, 0, 0, 4, 1, 0, 2, 2, 1]}", "c.json"),
              HasError("skew"));
  EXPECT_THAT(parse_open3d_camera(head, "c.json"), HasError("not valid JSON"));
}

TEST(CalibrationText, HasManyForms) {
  const auto fy = [](const std::string& text) {
    return value_of(parse_calibration_text(text, "c.txt")).intrinsics->fy;
  };
  EXPECT_EQ(fy("# camera\n481.2 -480 319.5 239.5\n"), -480);
  EXPECT_EQ(fy("481.2 0 319.5\n0 -480 239.5\n0 0 1\n"), -480);
  EXPECT_EQ(fy("481.2 0 319.5 0\n0 -480 239.5 0\n0 0 1 0\n0 0 0 1\n"), -480);
  EXPECT_EQ(fy("fx: 481.2\nfy = -480\ncx 319.5\ncy 239.5\ndepth_scale 1000\n"), -480);
  const auto sized =
      value_of(parse_calibration_text("528 528 320 240 640 480\ndepth_scale 1000\n", "c.txt"));
  EXPECT_EQ(sized.size->height, 480);
  EXPECT_EQ(*sized.depth_scale, 1000);
  const auto distorted = parse_calibration_text("528 528 320 240 0.26 -0.9 0 0 1.1\n", "c.txt");
  EXPECT_THAT(distorted->notes, Contains(HasSubstr("line 1 are not applied")));
}

TEST(DepthScale, CountsStepsOfAMetreOrMetresOfAStep) {
  EXPECT_EQ(metres_per_step(1000.0), 0.001);
  EXPECT_EQ(metres_per_step(0.00025), 0.00025);
  EXPECT_EQ(metres_per_step(1.0), 1.0);
}

TEST(CalibrationText, ErrorsNameTheLine) {
  const auto parse = [](const std::string& text) { return parse_calibration_text(text, "c.txt"); };
  EXPECT_THAT(parse("1 2 3\n"), HasError("c.txt: line 1: expected 'fx fy cx cy'"));
  EXPECT_THAT(parse("1 0 2\n0 1 nonsense\n0 0 1\n"), HasError("line 2"));
  EXPECT_THAT(parse("1 5 2\n0 1 2\n0 0 1\n"), HasError("without skew"));
  EXPECT_THAT(parse("\nfocal 5\n"), HasError("line 2"));
  EXPECT_THAT(parse("fx 5\n"), HasError("needs all of"));
  EXPECT_THAT(parse("0 1 2 3\n"), HasError("must not be 0"));
  EXPECT_THAT(parse("depth_scale -1\n"), HasError("must be positive"));
  EXPECT_THAT(parse(""), HasError("no intrinsics"));
}

class RgbdFolder : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
};

TEST_F(RgbdFolder, TumSequence) {
  folder_.write("depth.txt",
                "# depth maps\n1.00 depth/1.00.png\n2.00 depth/2.00.png\n3.00 depth/3.00.png\n");
  folder_.write("rgb.txt", "# colours\n1.015 rgb/a.png\n1.05 rgb/b.png\n2.1 rgb/a.png\n");
  folder_.write("groundtruth.txt",
                "# t\n0.995 0 0 0 0 0 0 1\n1.005 1 0 0 0 0 0 1\n9 0 0 0 0 0 0 1\n");
  folder_.write("other_trajectory.txt", "0.995 0 0 0 0 0 0 1\n");
  folder_.write("depth/1.00.png", png_head(5));
  folder_.write("depth/2.00.png", png_head(5));
  folder_.write("rgb/a.png", png_head(5));
  ASSERT_TRUE(is_rgbd_folder(folder_.path()));
  EXPECT_THAT(
      read_rgbd_folder(folder_.path()),
      HasError("depth maps without intrinsics", "--intrinsics FX FY CX CY", "calibration file"));
  EXPECT_THAT(read_rgbd_folder(folder_.path(), {PinholeIntrinsics{0, 525, 319.5, 239.5}, {}}),
              HasError("FX and FY of --intrinsics must not be 0"));
  folder_.write("calibration.txt", "525 525 319.5 239.5\n");
  const auto spec = value_of(read_rgbd_folder(folder_.path()));
  ASSERT_EQ(spec.views.size(), 2u);
  EXPECT_EQ(spec.views[0].name, "1.00");
  EXPECT_EQ(spec.views[0].depth->scale, 1.0 / 5000.0);
  EXPECT_EQ(spec.views[0].colour->file.filename(), "a.png");
  EXPECT_NEAR(spec.views[0].world_from_view.translation().x(), 0.5, 1e-12);
  EXPECT_EQ(spec.views[0].pose, PoseKind::kGuess);
  EXPECT_FALSE(spec.views[1].colour);
  EXPECT_EQ(spec.views[1].pose, PoseKind::kAbsent);
  EXPECT_EQ(spec.unit, "m");
  EXPECT_THAT(spec.notes, Contains(HasSubstr("left out 1 depth maps")));
  EXPECT_THAT(spec.notes, Contains(HasSubstr("1 of 2 depth maps have no pose")));
}

TEST_F(RgbdFolder, NamedFrames) {
  folder_.write("frame-000000.depth.png", png_head(5));
  folder_.write("frame-000000.pose.txt", kPose);
  folder_.write("frame-000000.color.png", png_head(5));
  folder_.write("frame-000001.depth.png", png_head(5));
  folder_.write("frame-000001.pose.txt", "-inf -inf -inf -inf\n");
  folder_.write("frame-000001.color.jpg", png_head(9));
  folder_.write("rtabmap.yaml", "camera_matrix: {rows: 3}\n");
  EXPECT_THAT(read_rgbd_folder(folder_.path()), HasError("none can be read in rtabmap.yaml"));
  folder_.write("intrinsics.txt", "525 0 319.5\n0 525 239.5\n0 0 1\n");
  EXPECT_THAT(read_rgbd_folder(folder_.path()), HasError("frame-000000.depth.png"));
  const auto spec = value_of(read_rgbd_folder(folder_.path(), {{}, 1000.0}));
  ASSERT_EQ(spec.views.size(), 2u);
  EXPECT_EQ(spec.views[0].name, "frame-000000");
  EXPECT_EQ(spec.views[0].world_from_view.translation(), Eigen::Vector3d(5, 6, 7));
  EXPECT_TRUE(spec.views[0].colour);
  EXPECT_FALSE(spec.views[1].colour);
  EXPECT_EQ(spec.views[1].pose, PoseKind::kAbsent);
  EXPECT_THAT(spec.notes, Contains(HasSubstr("1 of 2 colour images are not used")));
  folder_.write("frame-000001.pose.txt", "1 0 0 5\n0 3 0 6\n0 0 1 7\n0 0 0 1\n");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), kOptions),
              HasError("frame-000001.pose.txt: line 4: the pose is not a rigid motion"));
}

// A row of numbers that are no pose keeps its place.
TEST(Trajectories, LostPoses) {
  const auto plain = value_of(parse_tum_trajectory(
      "1 2 3 0 0 0 1\nnan nan nan nan nan nan nan\n0 0 0 0 0 0 0\n4 5 inf 0 0 0 1\n", "t.txt"));
  ASSERT_EQ(plain.size(), 4u);
  EXPECT_FALSE(plain[0].is_lost);
  for (const std::size_t i : {1u, 2u, 3u}) EXPECT_TRUE(plain[i].is_lost) << i;
  const auto timed =
      value_of(parse_tum_trajectory("1 0 0 0 0 0 0 1\n2 0 0 0 nan nan nan nan\n", "t.txt"));
  EXPECT_TRUE(pose_at(timed, 1.0, 0.02));
  EXPECT_FALSE(pose_at(timed, 2.0, 0.02));
  const auto rows = value_of(parse_matrix_trajectory(
      "1 0 0 5 0 1 0 6 0 0 1 7\n0 0 0 0 0 0 0 0 0 0 0 0\nnan 0 0 5 0 1 0 6 0 0 1 7\n", "t.txt"));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_TRUE(!rows[0].is_lost && rows[1].is_lost && rows[2].is_lost);
  const auto log = value_of(
      parse_log_trajectory("0 0 1\n1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n"
                           "1 1 2\nnan nan nan nan\nnan nan nan nan\nnan nan nan nan\n0 0 0 1\n"
                           "2 2 3\n0 0 0 0\n0 0 0 0\n0 0 0 0\n0 0 0 0\n",
                           "t.log"));
  ASSERT_EQ(log.size(), 3u);
  EXPECT_TRUE(!log[0].is_lost && log[1].is_lost && log[2].is_lost);
}

TEST_F(RgbdFolder, LostPosesOfATableAreNotTaken) {
  for (const char* name : {"depth/0.png", "depth/1.png"}) folder_.write(name, png_head(5));
  folder_.write("poses.csv", "frame,tx,ty,tz,qx,qy,qz,qw\n0,1,2,3,0,0,0,1\n1,,,,,,,\n");
  const ProjectSpec spec = value_of(read_rgbd_folder(folder_.path(), kOptions));
  EXPECT_EQ(spec.views.at(0).pose, PoseKind::kGuess);
  EXPECT_EQ(spec.views.at(1).pose, PoseKind::kAbsent);
  EXPECT_THAT(spec.notes, Contains(HasSubstr("1 of its 2 poses are no motion")));
}

TEST_F(RgbdFolder, ExtrinsicsOfFramesAreViewFromWorld) {
  folder_.write("frame-000000.depth.png", png_head(5));
  folder_.write("frame-000001.depth.png", png_head(5));
  folder_.write("frame-000000.extrinsic.txt", "0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n");
  const auto spec =
      value_of(read_rgbd_folder(folder_.path(), {PinholeIntrinsics{525, 525, 2, 2}, 1000.0}));
  ASSERT_EQ(spec.views.size(), 2u);
  const Eigen::Vector3d origin = spec.views[0].world_from_view * Eigen::Vector3d(5, 6, 7);
  EXPECT_LT(origin.norm(), 1e-12);
  EXPECT_EQ(spec.views[1].pose, PoseKind::kAbsent);
}

TEST_F(RgbdFolder, NamedFramesWithOtherSeparators) {
  folder_.write("000000_depth.png", png_head(5));
  folder_.write("000000_RGB.PNG", png_head(5));
  EXPECT_FALSE(is_rgbd_folder(folder_.path()));
  folder_.write("000000_pose.txt", kPose);
  const auto spec = value_of(read_rgbd_folder(folder_.path(), kOptions));
  ASSERT_EQ(spec.views.size(), 1u);
  EXPECT_EQ(spec.views[0].name, "000000");
  EXPECT_EQ(spec.views[0].world_from_view.translation(), Eigen::Vector3d(5, 6, 7));
  EXPECT_TRUE(spec.views[0].colour);
}

TEST_F(RgbdFolder, NumberedFolders) {
  for (const char* name : {"10", "9"})
    folder_.write("depth/" + std::string(name) + ".png", png_head(5));
  folder_.write("image/9.jpg", png_head(5));
  folder_.write("trajectory.log", std::string("0 0 1\n") + kPose +
                                      "1 1 2\n1 0 0 8\n0 1 0 0\n0 0 1 0\n" + "0 0 0 1\n");
  const auto spec = value_of(read_rgbd_folder(folder_.path(), kOptions));
  EXPECT_EQ(spec.views[0].name, "9");
  EXPECT_EQ(spec.views[0].world_from_view.translation().x(), 5.0);
  EXPECT_EQ(spec.views[1].world_from_view.translation().x(), 8.0);
  EXPECT_EQ(spec.views[1].camera->intrinsics.fy, -500);
  EXPECT_TRUE(spec.views[0].colour);
  folder_.write("depth/11.png", png_head(5));
  EXPECT_THAT(read_rgbd_folder(folder_.path(), kOptions),
              HasError("trajectory.log: 2 poses for 3 views"));
}

TEST_F(RgbdFolder, OfTwoTrajectoriesThatOfTheWholeIsTaken) {
  for (const char* name : {"0", "1"})
    folder_.write("depth/" + std::string(name) + ".png", png_head(5));
  const auto log = [](const std::string& last) {
    return std::string("0 0 1\n") + kPose + "1 1 2\n1 0 0 " + last +
           "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  };
  folder_.write("odometry.log", log("8"));
  folder_.write("trajectory.log", log("9"));
  const auto spec = value_of(read_rgbd_folder(folder_.path(), kOptions));
  EXPECT_EQ(spec.views[1].world_from_view.translation().x(), 9.0);
  folder_.write("second.log", log("7"));
  EXPECT_THAT(read_rgbd_folder(folder_.path(), kOptions), IsOk());
  std::filesystem::remove(folder_.path() / "trajectory.log");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), kOptions), HasError("is a trajectory, and so is"));
}

TEST_F(RgbdFolder, TrajectoryWithIntrinsics) {
  folder_.write("depth/0.png", png_head(5));
  folder_.write("camera_trajectory.json",
                R"({"parameters": [{"extrinsic": [1,0,0,0, 0,0,1,0, 0,-1,0,0, 1,2,3,1], "intrinsic":
        {"width": 5, "height": 4, "intrinsic_matrix": [50,0,0, 0,51,0, 2,1.5,1]}}]})");
  const auto spec = value_of(read_rgbd_folder(folder_.path(), {{}, 1000.0}));
  EXPECT_EQ(spec.views[0].camera->intrinsics.fy, 51);
  EXPECT_EQ(*spec.views[0].camera->width, 5);
  // View from world is x -> R x + (1, 2, 3) with R about x; its inverse has -R^T t.
  EXPECT_TRUE(spec.views[0].world_from_view.translation().isApprox(Eigen::Vector3d(-1, -3, 2)));
}

TEST_F(RgbdFolder, OtherFoldersAreNone) {
  folder_.write("a.txt", "1 2 3\n4 5 6\n");
  folder_.write("scan.json", "{}");
  EXPECT_FALSE(is_rgbd_folder(folder_.path()));
  EXPECT_FALSE(is_rgbd_folder(folder_ / "nothing"));
  EXPECT_THAT(read_rgbd_folder(folder_.path()), HasError("no depth maps in a layout"));
  folder_.write("depth.txt", "1 depth/1.png\n");
  EXPECT_THAT(read_rgbd_folder(folder_.path()),
              HasError("none of the 1 depth maps that its list names is there"));
}

TEST_F(RgbdFolder, CalibrationsThatDifferAreNamed) {
  folder_.write("depth/0.png", png_head(5));
  folder_.write("camera.txt", "1 1 2 2\n");
  folder_.write("intrinsics.txt", "2 2 2 2\n");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), {{}, 1000.0}), HasError("differs from camera.txt"));
  folder_.write("intrinsic_depth.txt", "3 3 2 2\n");
  const auto spec = value_of(read_rgbd_folder(folder_.path(), {{}, 1000.0}));
  EXPECT_EQ(spec.views[0].camera->intrinsics.fx, 3);
}

// Two frames in front of a slope, the second one higher, with so many values per metre.
void write_frames(const TemporaryFolder& folder, const Camera& camera, double scale = 1000.0,
                  float factor = 1.0f, bool along_ray = false) {
  for (int i = 0; i < 2; ++i) {
    RigidMotion pose = RigidMotion::Identity();
    pose.translation().y() = 0.4 * i;
    const RangeView view = testing::render(testing::plane({0, 0, 3}, {0, 0.5, -1}), camera, pose);
    Image depth(view.width(), view.height(), 1, 65535);
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        depth(u, v) =
            factor *
            static_cast<float>(std::lround(scale * view.range(u, v) *
                                           (along_ray ? camera.ray(u, v).direction.norm() : 1.0)));
    const std::string frame = "frame-" + std::to_string(i);
    folder.write(frame + ".depth.png", *encode_png(depth));
    folder.write(frame + ".pose.txt",
                 "1 0 0 0\n0 1 0 " + std::to_string(0.4 * i) + "\n0 0 1 0\n0 0 0 1\n");
  }
}

TEST_F(RgbdFolder, ReadsScanNetExports) {
  folder_.write("depth/0.png", png_head(5));
  folder_.write("pose/0.txt", kPose);
  folder_.write("intrinsic/extrinsic_depth.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  folder_.write("intrinsic/intrinsic_color.txt", "11 0 5 0\n0 12 6 0\n0 0 1 0\n0 0 0 1\n");
  folder_.write("intrinsic/intrinsic_depth.txt", "7 0 3 0\n0 8 4 0\n0 0 1 0\n0 0 0 1\n");
  const auto spec = value_of(read_rgbd_folder(folder_.path(), {std::nullopt, 1000.0}));
  ASSERT_EQ(spec.views.size(), 1u);
  EXPECT_EQ(spec.views[0].camera->intrinsics.fx, 7.0);
  EXPECT_EQ(spec.views[0].camera->intrinsics.cy, 4.0);
}

TEST_F(RgbdFolder, ReadsTartanAirsSides) {
  folder_.write("depth_left/000000_left_depth.png", png_head(5));
  folder_.write("depth_right/000000_right_depth.png", png_head(5));
  folder_.write("image_left/000000_left.png", png_head(5));
  EXPECT_FALSE(is_rgbd_folder(folder_.path()));
  folder_.write("pose_left.txt", "1 2 3 0 0 0 1\n");
  folder_.write("pose_right.txt", "4 5 6 0 0 0 1\n");
  const auto spec = value_of(read_rgbd_folder(folder_.path(), kOptions));
  ASSERT_EQ(spec.views.size(), 1u);
  EXPECT_EQ(spec.views[0].name, "000000_left_depth");
  EXPECT_EQ(spec.views[0].world_from_view.translation(), Eigen::Vector3d(1, 2, 3));
  ASSERT_TRUE(spec.views[0].colour);
  EXPECT_EQ(spec.views[0].colour->file.filename(), "000000_left.png");
}

TEST_F(RgbdFolder, ReadsReplica) {
  folder_.write("cam_params.json",
                R"({"camera": {"w": 4, "h": 3, "fx": 600.0, "fy": 601.0, "cx": 599.5,
                               "cy": 339.5, "scale": 6553.5}})");
  folder_.write("room0/results/depth000000.png", png_head(5));
  folder_.write("room0/results/frame000000.jpg", "");
  folder_.write("room0/traj.txt", "1 0 0 5 0 0 -1 6 0 1 0 7 0 0 0 1\n");
  ASSERT_TRUE(is_rgbd_folder(folder_ / "room0"));
  const auto spec = value_of(read_rgbd_folder(folder_ / "room0"));
  ASSERT_EQ(spec.views.size(), 1u);
  EXPECT_EQ(spec.views[0].name, "000000");
  EXPECT_EQ(spec.views[0].camera->intrinsics.fy, 601.0);
  EXPECT_EQ(spec.views[0].camera->width, 4);
  EXPECT_EQ(spec.views[0].depth->scale, 1.0 / 6553.5);
  EXPECT_EQ(spec.views[0].world_from_view.translation(), Eigen::Vector3d(5, 6, 7));
}

TEST_F(RgbdFolder, ReadsIntrinsicsBesideTheFolderOfFrames) {
  folder_.write("demo/camera-intrinsics.txt", "585 586 320 240 4 3\n");
  folder_.write("demo/notes.txt", "585 0 320 240\n");
  folder_.write("demo/rgbd-frames/frame-000008.depth.png", png_head(5));
  folder_.write("demo/rgbd-frames/frame-000008.color.png", png_head(5));
  folder_.write("demo/rgbd-frames/frame-000008.pose.txt", "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n");
  const auto spec = value_of(read_rgbd_folder(folder_ / "demo" / "rgbd-frames", {{}, 1000.0}));
  ASSERT_EQ(spec.views.size(), 1u);
  EXPECT_EQ(spec.views[0].camera->intrinsics.fy, 586.0);
  EXPECT_THAT(spec.notes, Contains(HasSubstr("camera-intrinsics.txt")));
}

TEST_F(RgbdFolder, SkipsHiddenFiles) {
  folder_.write("depth/0.png", png_head(5));
  folder_.write("depth/._0.png", "Mac OS X");
  folder_.write("._trajectory.txt", "Mac OS X");
  folder_.write("trajectory.txt", "1 2 3 0 0 0 1\n");
  EXPECT_EQ(value_of(read_rgbd_folder(folder_.path(), kOptions)).views.size(), 1u);
}

TEST_F(RgbdFolder, ReadsPosesOfLists) {
  folder_.write("depth/0.png", png_head(5));
  for (const char* pose :
       {kPose, "1,0,0,5\n0,0,-1,6\n0,1,0,7\n0,0,0,1\n",
        "[[1, 0, 0, 5],\n [0, 0, -1, 6],\n [0, 1, 0, 7],\n [0, 0, 0, 1]]\n",
        "1 0 0 5\n0 0 -1 6\n0 1 0 7\n", "1 0 0 0\n0 0 1 0\n0 -1 0 0\n5 6 7 1\n"}) {
    folder_.write("pose/0.txt", pose);
    const auto spec = value_of(read_rgbd_folder(folder_.path(), kOptions));
    const RigidMotion& found = spec.views.at(0).world_from_view;
    EXPECT_EQ(found.translation(), Eigen::Vector3d(5, 6, 7)) << pose;
    EXPECT_EQ(found * Eigen::Vector3d::UnitY(), Eigen::Vector3d(5, 6, 8)) << pose;
  }
}

TEST_F(RgbdFolder, ReadsAMatrixALine) {
  folder_.write("depth/0.png", png_head(5));
  for (const char* line : {"1 0 0 5 0 0 -1 6 0 1 0 7\n", "1 0 0 5 0 0 -1 6 0 1 0 7 0 0 0 1\n"}) {
    folder_.write("traj.txt", line);
    const auto spec = value_of(read_rgbd_folder(folder_.path(), kOptions));
    EXPECT_EQ(spec.views.at(0).world_from_view * Eigen::Vector3d::UnitY(),
              Eigen::Vector3d(5, 6, 8));
  }
  folder_.write("traj.txt", "1 0 0 5 0 0 -1 6 0 1 0 7\n1 0 0 5 0 0 -1 6 0 1 0\n");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), kOptions), HasError("line 2", "12 or 16 numbers"));
}

// Frames that were picked from a longer sequence.
TEST_F(RgbdFolder, TakesPosesByTheNumbersOfFrames) {
  folder_.write("depth/frame1.png", png_head(5));
  folder_.write("depth/frame3.png", png_head(5));
  const auto z_of_views = [&](const std::string& poses) {
    folder_.write("trajectory.txt", poses);
    std::vector<double> z;
    for (const ViewSpec& view : value_of(read_rgbd_folder(folder_.path(), kOptions)).views)
      z.push_back(view.world_from_view.translation().z());
    return z;
  };
  const auto pose = [](int z) { return "0 0 " + std::to_string(z) + " 0 0 0 1\n"; };
  EXPECT_EQ(z_of_views(pose(0) + pose(1) + pose(2) + pose(3)), (std::vector<double>{1, 3}));
  EXPECT_EQ(z_of_views(pose(1) + pose(2) + pose(3)), (std::vector<double>{1, 3}));
  EXPECT_EQ(z_of_views(pose(7) + pose(8)), (std::vector<double>{7, 8}));
  folder_.write("depth/last.png", png_head(5));
  EXPECT_THAT(read_rgbd_folder(folder_.path(), kOptions), HasError("2 poses for 3 views"));
}

TEST_F(RgbdFolder, LooksBesideAFolderWithoutCalibration) {
  folder_.write("depth/0.png", png_head(5));
  folder_.write("intrinsic/extrinsic_depth.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  folder_.write("camera.txt", "7 8 3 4\n");
  const auto spec = value_of(read_rgbd_folder(folder_.path(), {std::nullopt, 1000.0}));
  EXPECT_EQ(spec.views.at(0).camera->intrinsics.fx, 7.0);
}

// A camera at (1, 2, 3), turned by 90 degrees about its line of sight; y up, z back.
TEST_F(RgbdFolder, ReadsRecordingsOfRecord3d) {
  const auto metadata = [&](const std::string& k) {
    folder_.write("metadata.json", R"({"w": 20, "h": 40, "dw": 5, "dh": 10, "K": )" + k +
                                       R"(, "poses": [[0, 0, 0, 1, 0, 0, 0],
                                  [0, 0, 0.5, 0.5, 1, 2, 3]]})");
  };
  folder_.write("depth/1.png", png_head(5));
  metadata("[16, 0, 0, 0, 20, 0, 10, 22, 1]");
  const auto spec = value_of(read_rgbd_folder(folder_.path(), {std::nullopt, 1000.0}));
  ASSERT_EQ(spec.views.size(), 1u);
  const auto& camera = *spec.views[0].camera;
  EXPECT_EQ(camera.intrinsics.fx, 4.0);
  EXPECT_EQ(camera.intrinsics.fy, 5.0);
  EXPECT_EQ(camera.intrinsics.cx, 2.0);  // The middle of the first pixel is at 0, not at 0.5.
  EXPECT_EQ(camera.intrinsics.cy, 5.0);
  EXPECT_EQ(camera.width, 5);
  const Eigen::Vector3d right_and_ahead = spec.views[0].world_from_view * Eigen::Vector3d(1, 0, 1);
  EXPECT_TRUE(right_and_ahead.isApprox(Eigen::Vector3d(1, 3, 2), 1e-12));
  metadata("[0, 0, 0, 0, 20, 0, 10, 22, 1]");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), {std::nullopt, 1000.0}),
              HasError("metadata.json", "focal lengths"));
}

TEST_F(RgbdFolder, ReadsRecordingsOfStrayScanner) {
  folder_.write("camera_matrix.csv", "1440.0, 0.0, 959.5\n0.0, 1500.0, 719.5\n0.0, 0.0, 1.0");
  const std::string header = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
  const std::string first = "8.5, 000000, 0, 0, 0, 0, 0, 0, 1\n";
  folder_.write("odometry.csv", header + first + "8.6, 000020, 1, 2, 3, 0, 0, 1, 0\n");
  folder_.write("depth/000020.png", png_head(5));
  folder_.write("depth/000021.png", png_head(5));
  const auto spec = value_of(read_rgbd_folder(folder_.path(), {}));
  ASSERT_EQ(spec.views.size(), 2u);
  const auto& camera = *spec.views[0].camera;
  EXPECT_NEAR(camera.intrinsics.fx, 192.0, 1e-12);  // Of the video, 7.5 times as wide.
  EXPECT_NEAR(camera.intrinsics.fy, 200.0, 1e-12);
  EXPECT_NEAR(camera.intrinsics.cx, 127.5, 1e-12);
  EXPECT_EQ(spec.views[0].depth->scale, 0.001);
  const Eigen::Vector3d moved = spec.views[0].world_from_view * Eigen::Vector3d(1, 0, 1);
  EXPECT_TRUE(moved.isApprox(Eigen::Vector3d(0, 2, 4), 1e-12));
  EXPECT_EQ(spec.views[1].pose, PoseKind::kAbsent);
  EXPECT_FALSE(spec.views[0].mask);
  folder_.write("confidence/000021.png", png_head(5));
  const auto masked = value_of(read_rgbd_folder(folder_.path(), {}));
  EXPECT_FALSE(masked.views[0].mask);
  EXPECT_EQ(masked.views[1].mask->file, folder_.path() / "confidence/000021.png");

  folder_.write("odometry.csv",
                header + "8.6, 000020, 1, 2, 3, 0, 0, 1, 0, 750, 750, 959.5, 719.5\n");
  const auto later = value_of(read_rgbd_folder(folder_.path(), {}));
  EXPECT_NEAR(later.views[0].camera->intrinsics.fx, 100.0, 1e-12);
  EXPECT_NEAR(later.views[1].camera->intrinsics.fx, 192.0, 1e-12);

  folder_.write("odometry.csv", header + first + "8.6, 1, 2, 3\n");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), {}), HasError("odometry.csv", "line 3"));
  folder_.write("odometry.csv", header + "8.6, 000020, 1, 2, 3, 0, 0, 2, 0\n");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), {}), HasError("line 2", "quaternion"));
  folder_.write("camera_matrix.csv", "1440.0, 0.0\n");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), {}), HasError("camera_matrix.csv", "three numbers"));
}

TEST_F(RgbdFolder, ReadsScenesOfTheBopBenchmark) {
  const auto camera = [](const std::string& fx, const std::string& more) {
    return R"({"cam_K": [)" + fx + R"(, 0, 2, 0, 9, 5, 0, 0, 1], "depth_scale": 0.1)" + more + "}";
  };
  const std::string turn = "[0, -1, 0, 1, 0, 0, 0, 0, 1]";
  folder_.write("depth/000000.png", png_head(5));
  folder_.write("depth/000003.png", png_head(5));
  folder_.write("scene_camera.json",
                R"({"0": )" + camera("8", "") + R"(, "3": )" + camera("7", "") + "}");
  const auto none = value_of(read_rgbd_folder(folder_.path(), {}));
  ASSERT_EQ(none.views.size(), 2u);
  EXPECT_EQ(none.views[0].camera->intrinsics.fx, 8.0);
  EXPECT_EQ(none.views[1].camera->intrinsics.fx, 7.0);
  EXPECT_EQ(none.views[1].camera->intrinsics.cy, 5.0);
  EXPECT_NEAR(none.views[0].depth->scale, 1e-4, 1e-15);
  EXPECT_EQ(none.views[0].pose, PoseKind::kAbsent);

  const std::string object =
      R"({"obj_id": 4, "cam_R_m2c": )" + turn + R"(, "cam_t_m2c": [0, 0, 500]})";
  folder_.write("scene_gt.json", R"({"0": [)" + object + R"(], "3": [)" + object + "]}");
  const auto of_object = value_of(read_rgbd_folder(folder_.path(), {}));
  const Eigen::Vector3d seen = of_object.views[1].world_from_view * Eigen::Vector3d(0, 1, 0.5);
  EXPECT_TRUE(seen.isApprox(Eigen::Vector3d(1, 0, 0), 1e-12)) << seen.transpose();
  EXPECT_THAT(of_object.notes, Contains(HasSubstr("in the frame of the one object")));
  folder_.write("scene_gt.json",
                R"({"0": [)" + object + R"(], "3": [)" + object + "," + object + "]}");
  EXPECT_EQ(value_of(read_rgbd_folder(folder_.path(), {})).views[0].pose, PoseKind::kAbsent);

  const std::string known = R"(, "cam_R_w2c": )" + turn + R"(, "cam_t_w2c": [0, 0, 250])";
  folder_.write("scene_camera.json",
                R"({"0": )" + camera("8", known) + R"(, "3": )" + camera("7", known) + "}");
  const auto of_world = value_of(read_rgbd_folder(folder_.path(), {}));
  EXPECT_NEAR((of_world.views[0].world_from_view * Eigen::Vector3d::Zero()).z(), -0.25, 1e-12);

  folder_.write("scene_camera.json", R"({"0": {"cam_K": [1, 2]}})");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), {}), HasError("scene_camera.json", "0.cam_K"));
  folder_.write("scene_camera.json", R"({"first": )" + camera("8", "") + "}");
  EXPECT_THAT(read_rgbd_folder(folder_.path(), {}), HasError("first", "number of an image"));
}

TEST_F(RgbdFolder, TakesRayLengthsWhereDepthsAgreeSo) {
  const PinholeIntrinsics intrinsics{120, 120, 79.5, 59.5};
  for (const bool along_ray : {true, false}) {
    write_frames(folder_, Camera::pinhole(160, 120, intrinsics), 1000.0, 1.0f, along_ray);
    const auto spec = value_of(read_rgbd_folder(folder_.path(), {intrinsics, 1000.0}));
    for (const ViewSpec& view : spec.views) EXPECT_EQ(view.depth->along_ray, along_ray);
    const auto told = Contains(HasSubstr("taken as distances along the rays"));
    if (along_ray)
      EXPECT_THAT(spec.notes, told);
    else
      EXPECT_THAT(spec.notes, Not(told));
  }
}

TEST_F(RgbdFolder, TakesAUsualScaleWhereNoneIsStated) {
  const PinholeIntrinsics intrinsics{120, 120, 79.5, 59.5};
  for (const double scale : {1000.0, 5000.0, 100.0}) {
    write_frames(folder_, Camera::pinhole(160, 120, intrinsics), scale);
    const auto spec = value_of(read_rgbd_folder(folder_.path(), {intrinsics, {}}));
    for (const ViewSpec& view : spec.views) EXPECT_EQ(view.depth->scale, 1.0 / scale);
    EXPECT_THAT(spec.notes, Contains(AllOf(HasSubstr("--depth-scale"),
                                           HasSubstr(scale == 1000.0  ? "taken as millimetres;"
                                                     : scale == 100.0 ? "taken as centimetres,"
                                                                      : "5000 to the metre"))));
  }
  // As SUN3D writes them.
  write_frames(folder_, Camera::pinhole(160, 120, intrinsics), 1000.0, 8.0f);
  const auto shifted = value_of(read_rgbd_folder(folder_.path(), {intrinsics, {}}));
  EXPECT_EQ(shifted.views[0].depth->scale, 1.0 / 8000.0);
  EXPECT_THAT(shifted.notes, Contains(HasSubstr("multiples of 8")));
  // A map without a depth, or of one depth, tells nothing.
  for (const float depth : {0.0f, 800.0f}) {
    Image flat(160, 120, 1, 65535);
    std::fill(flat.samples.begin(), flat.samples.end(), depth);
    folder_.write("frame-0.depth.png", *encode_png(flat));
    const auto spec = value_of(read_rgbd_folder(folder_.path(), {intrinsics, {}}));
    EXPECT_EQ(spec.views[0].depth->scale, 0.001);
  }
  // Poses that tell nothing.
  write_frames(folder_, Camera::pinhole(160, 120, intrinsics), 1000.0);
  for (const char* frame : {"frame-0", "frame-1"})
    fs::remove(folder_ / (frame + std::string(".pose.txt")));
  const auto spec = value_of(read_rgbd_folder(folder_.path(), {intrinsics, {}}));
  EXPECT_EQ(spec.views[0].depth->scale, 0.001);
}

TEST(RgbdOnRealData, TellTheScaleByTheirPoses) {
  RELIEF_REQUIRE_TEST_DATA(folder, "rgbd");
  const auto spec =
      value_of(read_rgbd_folder(folder, {PinholeIntrinsics{481.2, -480, 319.5, 239.5}, {}}));
  EXPECT_EQ(spec.views[0].depth->scale, 1.0 / 5000.0);
}

// ICL-NUIM's poses are those of a left-handed world.
TEST(RgbdOnRealData, PosesOfALeftHandedWorldAreFound) {
  RELIEF_REQUIRE_TEST_DATA(folder, "rgbd");
  const auto notes = [&](double fy) {
    return read_rgbd_folder(folder, {PinholeIntrinsics{481.2, fy, 319.5, 239.5}, 5000.0})->notes;
  };
  EXPECT_THAT(notes(-480), Not(Contains(HasSubstr("left-handed"))));
  EXPECT_THAT(notes(480), Contains(HasSubstr("left-handed")));
}

TEST(RgbdOnRealData, TumTexts) {
  RELIEF_REQUIRE_TEST_DATA(folder, "formats/tum");
  const auto read = [&](const char* name) { return read_file(folder / name).value(); };
  EXPECT_EQ(parse_tum_list(read("depth.txt"), "depth.txt")->size(), 798u);
  EXPECT_EQ(parse_tum_list(read("rgb.txt"), "rgb.txt")->size(), 798u);
  const auto pairs = value_of(parse_tum_associations(read("rgb-depth-synced.txt"), "a.txt"));
  EXPECT_EQ(pairs.front().depth.file, "depth/1305031102.160407.png");
  const auto trajectory =
      value_of(parse_tum_trajectory(read("groundtruth.txt"), "groundtruth.txt"));
  EXPECT_EQ(trajectory.size(), 3000u);
}

TEST(RgbdOnRealData, Open3dFiles) {
  RELIEF_REQUIRE_TEST_DATA(folder, "formats/open3d");
  const auto read = [&](const char* name) { return read_file(folder / name).value(); };
  EXPECT_EQ(parse_open3d_camera(read("camera_primesense.json"), "c")->intrinsics->cy, 239.5);
  EXPECT_EQ(parse_log_trajectory(read("trajectory.log"), "t")->size(), 5u);
  EXPECT_FALSE(parse_log_trajectory(read("init.log"), "t"));
  const auto trajectory = value_of(parse_open3d_trajectory(read("camera_trajectory.json"), "t"));
  EXPECT_EQ(trajectory.at(0).intrinsics->cx, 959.5);
}

// Poses, the mirrored focal length and the depth scale are right when the views agree.
TEST(RgbdOnRealData, ViewsOfTheRoomAgree) {
  RELIEF_REQUIRE_TEST_DATA(folder, "rgbd");
  ASSERT_TRUE(is_rgbd_folder(folder));
  const auto spec =
      value_of(read_rgbd_folder(folder, {PinholeIntrinsics{481.2, -480, 319.5, 239.5}, 5000.0}));
  ASSERT_EQ(spec.views.size(), 5u);
  std::vector<RangeView> views;
  for (const ViewSpec& view : spec.views) views.push_back(load_view(view).value().view);
  EXPECT_FALSE(views[0].colours.empty());
  std::size_t seen = 0, agreeing = 0;
  const RigidMotion b_from_a = views[0].world_from_view.inverse() * views[2].world_from_view;
  for (int v = 0; v < views[2].height(); v += 4) {
    for (int u = 0; u < views[2].width(); u += 4) {
      if (!views[2].has_sample(u, v)) continue;
      const Eigen::Vector3d x = b_from_a * views[2].point(u, v);
      const auto pixel = views[0].camera.project(x);
      if (!pixel) continue;
      const int c = static_cast<int>(std::lround(pixel->x()));
      const int r = static_cast<int>(std::lround(pixel->y()));
      if (!views[0].has_sample(c, r)) continue;
      ++seen;
      agreeing += std::abs(views[0].range(c, r) - x.z()) < 0.02;
    }
  }
  EXPECT_GT(seen, 3000u);
  EXPECT_GT(static_cast<double>(agreeing), 0.8 * static_cast<double>(seen));
}

}  // namespace
}  // namespace relief
