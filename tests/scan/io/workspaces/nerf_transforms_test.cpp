#include "scan/io/workspaces/rgbd/nerf_transforms.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/io/project_io.h"
#include "scan/io/images/image_io.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::Contains;
using testing::HasError;
using ::testing::HasSubstr;
using testing::TemporaryFolder;
using testing::value_of;

// A camera at (1, 2, 3) that looks along -z, up y.
constexpr const char* kPose =
    R"("transform_matrix": [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])";

std::string image_of(int width, int height, int channels, float value) {
  Image image(width, height, channels, channels == 1 ? 65535 : 255);
  image.samples.assign(image.samples.size(), value);
  return *encode_png(image);
}

class NerfTransformsTest : public ::testing::Test {
 protected:
  NerfTransformsTest() {
    std::filesystem::create_directories(folder_ / "depth");
    std::filesystem::create_directories(folder_ / "images");
    folder_.write("depth/a.png", image_of(20, 10, 1, 1500));
    folder_.write("depth/b.png", image_of(20, 10, 1, 1500));
    folder_.write("images/a.png", image_of(20, 10, 3, 90));
    folder_.write("images/b.png", image_of(40, 20, 3, 90));
  }

  std::string frame(const std::string& name) const {
    return R"({"file_path": "./images/)" + name + R"(.png", "depth_file_path": "depth/)" + name +
           ".png\", " + kPose + "}";
  }

  std::filesystem::path write(const std::string& head, const std::string& frames) const {
    return folder_.write("transforms.json", "{" + head + ", \"frames\": [" + frames + "]}");
  }

  const TemporaryFolder folder_;
  const std::string all_ = R"("fl_x": 60, "fl_y": 62, "cx": 20, "cy": 10.5, "w": 40, "h": 20)";
};

TEST_F(NerfTransformsTest, FramesAreViewsInMetres) {
  write(all_, frame("a") + ", " + frame("b"));
  const auto project = value_of(read_project(folder_.path()));
  ASSERT_EQ(project.views.size(), 2u);
  EXPECT_EQ(project.unit, "m");
  const RangeView& view = project.views[0];
  EXPECT_EQ(view.name, "a");
  EXPECT_EQ(view.pose, PoseKind::kGuess);
  EXPECT_NEAR(view.range(3, 4), 1.5, 1e-9);
  // The images are twice as large; the centre of their first pixel is at (0.5, 0.5).
  const Ray ray = view.camera.ray(0, 0);
  EXPECT_TRUE(ray.direction.isApprox(Eigen::Vector3d(-9.5 / 30, -4.75 / 31, 1), 1e-12));
  const Eigen::Vector3d world = view.world_from_view * (1.5 * Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(world.isApprox(Eigen::Vector3d(1, 2, 1.5)));
  EXPECT_TRUE((view.world_from_view.linear() * Eigen::Vector3d::UnitY())
                  .isApprox(-Eigen::Vector3d::UnitY()));
  EXPECT_FALSE(view.colours.empty());
  EXPECT_TRUE(project.views[1].colours.empty()) << "another size";
  EXPECT_THAT(project.notes, Contains(HasSubstr("steps of 0.001 m")));
}

// By the file, or by the folder that holds it.
TEST_F(NerfTransformsTest, PosesOfItsFramesAreWritten) {
  const auto file = write(all_, frame("a") + ", " + frame("b"));
  for (const auto& source : {file, folder_.path()}) {
    auto project = value_of(read_project(source));
    project.views[1].world_from_view.translation().x() = 7.0;
    const auto output = folder_ / "out" / "aligned.json";
    std::filesystem::create_directories(output.parent_path());
    ASSERT_TRUE(write_project_poses(project, source, {}, output));
    const auto written = value_of(read_project(output));
    ASSERT_EQ(written.views.size(), 2u);
    EXPECT_EQ(written.views[1].world_from_view.translation().x(), 7.0);
    EXPECT_NEAR(written.views[1].range(3, 4), 1.5, 1e-9);
  }
}

TEST_F(NerfTransformsTest, OptionsAndTheFileTellTheScale) {
  const auto path = write(all_ + R"(, "integer_depth_scale": 0.0002)", frame("a"));
  EXPECT_NEAR(value_of(read_project(path)).views[0].range(3, 4), 0.3, 1e-9);
  ReadProjectOptions options;
  options.depth_scale = 5000;
  EXPECT_NEAR(value_of(read_project(write(all_, frame("a")), options)).views[0].range(3, 4), 0.3,
              1e-9);
}

TEST_F(NerfTransformsTest, TheFieldOfViewTellsTheFocalLength) {
  const auto project =
      value_of(read_project(write(R"("camera_angle_x": 1.5707963267948966)", frame("a"))));
  EXPECT_NEAR(project.views[0].camera.ray(19, 0).direction.x(), 9.5 / 10.0, 1e-9);
}

TEST_F(NerfTransformsTest, FramesWithoutDepthAreLeftOut) {
  const auto path = write(all_ + R"(, "k1": 0.1)", frame("a") + ", " + frame("gone"));
  const auto project = value_of(read_project(path));
  EXPECT_EQ(project.views.size(), 1u);
  EXPECT_THAT(project.notes, Contains(HasSubstr("1 of 2 frames name no depth map")));
  EXPECT_THAT(project.notes, Contains(HasSubstr("distortion")));
}

TEST_F(NerfTransformsTest, ErrorsNameThePlace) {
  const auto error = [&](const std::string& head, const std::string& frames) {
    return read_project(write(head, frames));
  };
  EXPECT_THAT(error(all_, std::string("{") + kPose + "}"),
              HasError("transforms.json: frames: none names a depth map"));
  EXPECT_THAT(error("\"w\": 40", frame("a")), HasError("frames[0].fl_x: missing"));
  for (const char* zero : {"\"fl_x\": 0", "\"fl_x\": 60, \"fl_y\": 0", "\"fl_x\": 60, \"w\": 0",
                           "\"camera_angle_x\": 0"})
    EXPECT_THAT(error(zero, frame("a")), HasError("frames[0].fl_x: no camera")) << zero;
  EXPECT_THAT(error(all_, R"({"depth_file_path": "depth/a.png", "transform_matrix": [1]})"),
              HasError("frames[0].transform_matrix: expected four rows"));
  EXPECT_THAT(error(all_, R"({"depth_file_path": 5, "transform_matrix": [1]})"),
              HasError("frames[0].depth_file_path: expected a text"));
}

TEST_F(NerfTransformsTest, DamagedFilesEndInErrorsOrViews) {
  std::string text = "{" + all_ + ", \"frames\": [" + frame("a") + "]}";
  for (std::size_t at = 0; at < text.size(); ++at) {
    std::string damaged = text;
    damaged[at] = '9';
    (void)parse_nerf_transforms(damaged, folder_ / "transforms.json");
    (void)parse_nerf_transforms(text.substr(0, at), folder_ / "transforms.json");
  }
}

// A similarity, as some programs write it: its scale is in the last number.
TEST_F(NerfTransformsTest, MatricesMayBeTimesANumber) {
  const auto path = write(all_, R"({"depth_path": "depth/a.png", "transform_matrix": )"
                                R"([[2, 0, 0, 2], [0, 2, 0, 4], [0, 0, 2, 6], [0, 0, 0, 2]]})");
  const auto project = value_of(read_project(path));
  EXPECT_TRUE(project.views[0].world_from_view.translation().isApprox(Eigen::Vector3d(1, 2, 3)));
}

}  // namespace
}  // namespace relief
