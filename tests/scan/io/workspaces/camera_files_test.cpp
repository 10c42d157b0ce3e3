#include "scan/io/workspaces/rgbd/calibration/camera_files.h"

#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scan/io/small_files.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// fx fy cx cy; four zeros for no calibration.
std::vector<double> numbers(const std::optional<Calibration>& calibration) {
  if (!calibration) return {0, 0, 0, 0};
  const PinholeIntrinsics k = *calibration->intrinsics;
  return {k.fx, k.fy, k.cx, k.cy};
}

TEST(CameraJson, HasManyForms) {
  const auto read = [](const std::string& text) { return numbers(parse_camera_json(text)); };
  EXPECT_THAT(read(R"({"fx": 5, "fy": 6, "cx": 7, "cy": 8})"), ElementsAre(5, 6, 7, 8));
  EXPECT_THAT(read(R"({"depth": {"fx": 5, "fy": 6, "ppx": 7, "ppy": 8}})"),
              ElementsAre(5, 6, 7, 8));
  EXPECT_THAT(read(R"({"K": [[5, 0, 7], [0, 6, 8], [0, 0, 1]], "0": 1})"), ElementsAre(5, 6, 7, 8));
  for (const char* other : {R"({"fx": 5, "fy": 6})", R"({"K": [[5, 1, 7], [0, 6, 8], [0, 0, 1]]})",
                            R"({"K": [5, 0, 7]})", R"([1])", "no JSON"})
    EXPECT_THAT(read(other), ElementsAre(0, 0, 0, 0)) << other;
  EXPECT_THAT(read(R"({"fx": 0, "fy": 6, "cx": 7, "cy": 8})"), ElementsAre(0, 0, 0, 0));
  const auto whole = parse_camera_json(
      R"({"fx": 5, "fy": 6, "cx": 7, "cy": 8, "width": 16, "height": 9, "depth_scale": 1000})");
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->size->width, 16);
  EXPECT_EQ(*whole->depth_scale, 1000.0);
}

TEST(CameraYaml, IsOfOrbSlamOrRos) {
  const std::string orb =
      "%YAML:1.0\n# Camera\nCamera.fx: 5\nCamera.fy: 6\nCamera.cx: 7\nCamera.cy: 8\n"
      "Camera.k1: 0.0\nCamera.width: 16\nCamera.height: 9\nDepthMapFactor: 5000.0\n";
  EXPECT_THAT(numbers(parse_camera_yaml(orb, "c.yaml")), ElementsAre(5, 6, 7, 8));
  const auto whole = parse_camera_yaml(orb, "c.yaml");
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->size->height, 9);
  EXPECT_EQ(*whole->depth_scale, 5000.0);
  EXPECT_TRUE(whole->notes.empty());
  for (const char* distortion :
       {"Camera.p1: 0.1\n", "D: [0, 0.1, 0, 0, 0]\n",
        "distortion_coefficients:\n  rows: 1\n  data: [0, 0.1, 0, 0, 0]\n"})
    EXPECT_THAT(parse_camera_yaml(orb + distortion, "c.yaml")->notes,
                ElementsAre(HasSubstr("distortion in c.yaml are not applied")));
  EXPECT_THAT(
      numbers(parse_camera_yaml("image_width: 16\ncamera_matrix:\n  rows: 3\n  data: [5, 0, "
                                "7,\n  0, 6, 8, 0, 0, 1]\n",
                                "c.yaml")),
      ElementsAre(5, 6, 7, 8));
  EXPECT_THAT(numbers(parse_camera_yaml("K: [5, 0, 7, 0, 6, 8, 0, 0, 1]\n", "c.yaml")),
              ElementsAre(5, 6, 7, 8));
  EXPECT_THAT(numbers(parse_camera_yaml("K: [5, 0\ncamera_matrix: x\n", "c.yaml")),
              ElementsAre(0, 0, 0, 0));
  EXPECT_FALSE(parse_camera_yaml("Camera.fx: 5\n", "c.yaml"));
}

TEST(IntrinsicsOfMatrix, HaveNoSkewAndALastRow) {
  EXPECT_EQ(intrinsics_of_matrix(std::vector<double>{5, 0, 7, 0, 6, 8, 0, 0, 1})->cy, 8.0);
  EXPECT_FALSE(intrinsics_of_matrix(std::vector<double>{0.9, -0.1, 0, 0.1, 0.9, 0, 0, 0, 1}));
  EXPECT_FALSE(intrinsics_of_matrix(std::vector<double>{5, 0, 7, 0, 6, 8, 0, 0, 2}));
  EXPECT_FALSE(intrinsics_of_matrix(std::vector<double>{5, 0, 7, 0, 6, 8}));
}

class Calibrations : public ::testing::Test {
 protected:
  std::optional<Calibration> found() const { return value_of(find_calibration(folder_.path())); }
  testing::TemporaryFolder folder_;
};

TEST_F(Calibrations, OfFilesThatMayHoldSomethingElseComeLast) {
  folder_.write("a.json", R"({"fx": 9, "fy": 9, "cx": 9, "cy": 9})");
  EXPECT_EQ(found()->intrinsics->fx, 9.0);
  folder_.write("camera.txt", "5 6 7 8\n");
  folder_.write("TUM.yaml",
                "Camera.fx: 5\nCamera.fy: 6\nCamera.cx: 7\nCamera.cy: 8\nDepthMapFactor: 5000\n");
  EXPECT_EQ(found()->intrinsics->fx, 5.0);
  EXPECT_EQ(*found()->depth_scale, 5000.0);  // Which camera.txt does not tell.
}

TEST_F(Calibrations, OfTheSameKindMustAgree) {
  folder_.write("a.json", R"({"fx": 9, "fy": 9, "cx": 9, "cy": 9})");
  folder_.write("b.json", R"({"fx": 8, "fy": 9, "cx": 9, "cy": 9})");
  EXPECT_THAT(find_calibration(folder_.path()), HasError("b.json: differs from a.json"));
  folder_.write("depth.json", R"({"fx": 7, "fy": 9, "cx": 9, "cy": 9})");
  EXPECT_EQ(found()->intrinsics->fx, 7.0);
}

TEST_F(Calibrations, MayBeANumPyArray) {
  folder_.write("K.npy", testing::npy_array("(1, 3, 3)", {5, 0, 7, 0, 6, 8, 0, 0, 1}));
  EXPECT_EQ(found()->intrinsics->cy, 8.0);
}

}  // namespace
}  // namespace relief
