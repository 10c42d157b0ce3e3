#include "scan/io/workspaces/rgbd/calibration/camera_files.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"

namespace relief {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// fx fy cx cy; four zeros for no calibration.
std::vector<double> numbers(const Result<std::optional<Calibration>>& read) {
  const auto calibration = value_of(read);
  if (!calibration) return {0, 0, 0, 0};
  const PinholeIntrinsics k = *calibration->intrinsics;
  return {k.fx, k.fy, k.cx, k.cy};
}

TEST(CameraJson, HasManyForms) {
  const auto read = [](const std::string& text) {
    return numbers(parse_camera_json(text, "c.json"));
  };
  EXPECT_THAT(read(R"({"fx": 5, "fy": 6, "cx": 7, "cy": 8})"), ElementsAre(5, 6, 7, 8));
  EXPECT_THAT(read(R"({"depth": {"fx": 5, "fy": 6, "ppx": 7, "ppy": 8}})"),
              ElementsAre(5, 6, 7, 8));
  EXPECT_THAT(read(R"({"K": [[5, 0, 7], [0, 6, 8], [0, 0, 1]], "0": 1})"), ElementsAre(5, 6, 7, 8));
  for (const char* other : {R"({"fx": 5, "fy": 6})", R"({"K": [[5, 1, 7], [0, 6, 8], [0, 0, 1]]})",
                            R"({"K": [5, 0, 7]})", R"([1])", "no JSON"})
    EXPECT_THAT(read(other), ElementsAre(0, 0, 0, 0)) << other;
  EXPECT_THAT(parse_camera_json(R"({"fx": 0, "fy": 6, "cx": 7, "cy": 8})", "c.json"),
              HasError("c.json: the focal lengths"));
  const auto whole = value_of(parse_camera_json(
      R"({"fx": 5, "fy": 6, "cx": 7, "cy": 8, "width": 16, "height": 9, "depth_scale": 1000})",
      "c.json"));
  EXPECT_EQ(whole->size->width, 16);
  EXPECT_EQ(*whole->depth_scale, 1000.0);
}

TEST(CameraYaml, IsOfOrbSlamOrRos) {
  const std::string orb =
      "%YAML:1.0\n# Camera\nCamera.fx: 5\nCamera.fy: 6\nCamera.cx: 7\nCamera.cy: 8\n"
      "Camera.k1: 0.0\nCamera.width: 16\nCamera.height: 9\nDepthMapFactor: 5000.0\n";
  EXPECT_THAT(numbers(parse_camera_yaml(orb, "c.yaml")), ElementsAre(5, 6, 7, 8));
  const auto whole = value_of(parse_camera_yaml(orb, "c.yaml"));
  EXPECT_EQ(whole->size->height, 9);
  EXPECT_EQ(*whole->depth_scale, 5000.0);
  EXPECT_TRUE(whole->notes.empty());
  EXPECT_THAT(value_of(parse_camera_yaml(orb + "Camera.p1: 0.1\n", "c.yaml"))->notes,
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
  EXPECT_THAT(parse_camera_yaml("Camera.fx: 5\n", "c.yaml"), HasError("c.yaml: needs all of"));
}

}  // namespace
}  // namespace relief
