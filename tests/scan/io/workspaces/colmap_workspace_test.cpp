#include "scan/io/workspaces/colmap/colmap_workspace.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/files/binary_writer.h"
#include "scan/io/images/codecs/floats/colmap_array.h"
#include "scan/io/workspaces/colmap/colmap_model.h"
#include "scan/io/workspaces/depth_differences.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_data.h"

namespace relief {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

std::string array_bytes(const std::string& header, const std::vector<float>& values) {
  std::string bytes = header;
  for (const float value : values) append_little_endian(bytes, value);
  return bytes;
}

TEST(ColmapArray, ReadsPlanes) {
  const auto image = value_of(
      decode_colmap_array(array_bytes("2&1&3&", {0.1f, 0.2f, 1e-30f, -3.5f, 5.0f, 6.0f}), "a.bin"));
  EXPECT_EQ(image.width, 2);
  EXPECT_EQ(image.height, 1);
  EXPECT_EQ(image.max_value, 0.0);
  EXPECT_EQ(image.samples, (std::vector<float>{0.1f, 1e-30f, 5.0f, 0.2f, -3.5f, 6.0f}));
}

TEST(ColmapArray, ErrorsSayWhatIsWrong) {
  const auto decode = [](const std::string& bytes) { return decode_colmap_array(bytes, "a.bin"); };
  EXPECT_THAT(decode(""), HasError("a.bin: byte 0: expected 'width&height&channels&'"));
  EXPECT_THAT(decode("2&1&"), HasError("byte 0"));
  EXPECT_THAT(decode("2x1&1&"), HasError("byte 0"));
  EXPECT_THAT(decode("2&1&2&"), HasError("2 channels"));
  EXPECT_THAT(decode("0&1&1&"), HasError("empty"));
  EXPECT_THAT(decode("60000&4000&1&abcd"), HasError("truncated"));
  EXPECT_THAT(decode("18446744073709551615&4&1&abcd"), HasError("more than can be read"));
  EXPECT_THAT(decode(array_bytes("2&1&1&", {1, 2, 3})), HasError("12 follow"));
  const std::string whole = array_bytes("2&1&1&", {1, 2});
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(decode_colmap_array(whole.substr(0, size), "a.bin")) << size;
}

// A model of two images 8x6 that see a plane z = 2: one at the origin, one a step aside and turned.
struct SmallModel {
  static std::string cameras_bin(int model = 1) {
    std::string bytes;
    append_little_endian<std::uint64_t>(bytes, 1);
    append_little_endian<std::uint32_t>(bytes, 7);
    append_little_endian<std::int32_t>(bytes, model);
    append_little_endian<std::uint64_t>(bytes, 8);
    append_little_endian<std::uint64_t>(bytes, 6);
    for (const double number : {10.0, 12.0, 4.0, 3.0}) append_little_endian(bytes, number);
    return bytes;
  }
  static std::string images_bin(double w = 0.6) {
    std::string bytes;
    append_little_endian<std::uint64_t>(bytes, 2);
    for (std::uint32_t id : {3u, 4u}) {
      append_little_endian(bytes, id);
      const bool first = id == 3;
      for (const double number : {first ? 1.0 : w, 0.0, 0.0, first ? 0.0 : 0.8, first ? 0.0 : 1.0,
                                  first ? 0.0 : 2.0, 0.0})
        append_little_endian(bytes, number);
      append_little_endian<std::uint32_t>(bytes, 7);
      bytes += first ? "b/one.jpg" : "two.jpg";
      bytes += '\0';
      append_little_endian<std::uint64_t>(bytes, 1);
      append_little_endian(bytes, 1.5);
      append_little_endian(bytes, 2.5);
      append_little_endian<std::uint64_t>(bytes, 1);
    }
    return bytes;
  }
  static std::string points_bin() {
    std::string bytes;
    append_little_endian<std::uint64_t>(bytes, 1);
    append_little_endian<std::uint64_t>(bytes, 1);
    for (const double number : {0.1, 0.1, 2.0}) append_little_endian(bytes, number);
    bytes += "rgb";
    append_little_endian(bytes, 0.5);
    append_little_endian<std::uint64_t>(bytes, 1);
    append_little_endian<std::uint32_t>(bytes, 3);
    append_little_endian<std::uint32_t>(bytes, 0);
    return bytes;
  }
};

const char* const kCamerasText = "# cameras\n7 PINHOLE 8 6 10 12 4 3\n";
const char* const kImagesText =
    "# images\n3 1 0 0 0 0 0 0 7 b/one.jpg\n\n4 0.6 0 0 0.8 1 2 0 7 two.jpg\n1.5 2.5 1\n";
const char* const kPointsText = "# points\n1 0.1 0.1 2 10 20 30 0.5 3 0\n";

TEST(ColmapModel, BinaryAndTextAgree) {
  const auto cameras = value_of(parse_colmap_cameras_bin(SmallModel::cameras_bin(), "cameras.bin"));
  const auto cameras_text = value_of(parse_colmap_cameras_txt(kCamerasText, "cameras.txt"));
  for (const auto& camera : {cameras.at(0), cameras_text.at(0)}) {
    EXPECT_EQ(camera.id, 7u);
    EXPECT_EQ(camera.width, 8u);
    EXPECT_EQ(camera.intrinsics.fy, 12.0);
    EXPECT_EQ(camera.intrinsics.cy, 3.0);
  }
  const auto images = value_of(parse_colmap_images_bin(SmallModel::images_bin(), "images.bin"));
  const auto images_text = value_of(parse_colmap_images_txt(kImagesText, "images.txt"));
  ASSERT_EQ(images_text.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(images.at(i).name, images_text.at(i).name);
    EXPECT_EQ(images.at(i).world_from_view.matrix(), images_text.at(i).world_from_view.matrix());
  }
  // The camera's centre is -R^T t.
  EXPECT_TRUE(images.at(1).world_from_view.translation().isApprox(
      Eigen::Vector3d(0.28 - 1.92, 0.96 + 0.56, 0), 1e-12));
  const auto points = value_of(parse_colmap_points_bin(SmallModel::points_bin(), "points3D.bin"));
  const auto points_text = value_of(parse_colmap_points_txt(kPointsText, "points3D.txt"));
  EXPECT_EQ(points.points, points_text.points);
  EXPECT_EQ(points.sightings.at(0).image_id, points_text.sightings.at(0).image_id);
}

TEST(ColmapModel, ErrorsNameThePlaceAndTheRemedy) {
  EXPECT_THAT(parse_colmap_cameras_bin(SmallModel::cameras_bin(4), "cameras.bin"),
              HasError("cameras.bin: byte 8: ", "OPENCV", "image_undistorter"));
  EXPECT_THAT(parse_colmap_cameras_bin(SmallModel::cameras_bin(99), "cameras.bin"),
              HasError("number 99"));
  EXPECT_THAT(parse_colmap_cameras_txt("\n1 SIMPLE_RADIAL 8 6 1 2 3 4\n", "cameras.txt"),
              HasError("cameras.txt: line 2: camera 1 has the model SIMPLE_RADIAL"));
  EXPECT_THAT(parse_colmap_cameras_txt("1 PINHOLE 8 6 1 2 3\n", "c"),
              HasError("expected fx fy cx cy"));
  EXPECT_THAT(parse_colmap_cameras_txt("1 PINHOLE 1e9 6 1 2 3 4\n", "c"), HasError("image size"));
  EXPECT_THAT(parse_colmap_cameras_txt("1 PINHOLE 8 6 0 2 3 4\n", "c"),
              HasError("focal lengths other than 0"));
  EXPECT_THAT(parse_colmap_images_bin(SmallModel::images_bin(0.7), "images.bin"),
              HasError("the pose of image two.jpg is no rigid motion"));
  EXPECT_THAT(parse_colmap_images_txt("3 1 0 0 0 0 0 7 a.jpg\n", "i"),
              HasError("line 1: expected 'IMAGE_ID"));
  EXPECT_THAT(parse_colmap_points_txt("1 2 3\n", "p"), HasError("line 1: expected"));
  EXPECT_THAT(parse_colmap_cameras_bin(std::string(8, '\xff'), "c"),
              HasError("more than its 8 bytes can hold"));
  EXPECT_THAT(parse_colmap_cameras_bin(SmallModel::cameras_bin() + "x", "c"),
              HasError("1 bytes follow the last record"));
}

// A workspace of the small model; its depth maps are half as large as the images.
class ColmapWorkspace : public ::testing::Test {
 protected:
  ColmapWorkspace() {
    for (const char* name : {"sparse", "stereo/depth_maps/b", "stereo/normal_maps/b"})
      fs::create_directories(folder_ / name);
    folder_.write("sparse/cameras.bin", SmallModel::cameras_bin());
    folder_.write("sparse/images.bin", SmallModel::images_bin());
    folder_.write("sparse/points3D.bin", SmallModel::points_bin());
  }
  void write_depth(const std::string& name, float depth = 2.0f) const {
    folder_.write("stereo/depth_maps/" + name,
                  array_bytes("4&3&1&", std::vector<float>(12, depth)));
  }

  TemporaryFolder folder_;
};

TEST_F(ColmapWorkspace, ScalesTheCameraAndNamesWhatIsMissing) {
  write_depth("b/one.jpg.geometric.bin");
  folder_.write("stereo/normal_maps/b/one.jpg.geometric.bin", "");
  ASSERT_TRUE(is_colmap_workspace(folder_.path()));
  const auto spec = value_of(read_colmap_workspace(folder_.path()));
  ASSERT_EQ(spec.views.size(), 1u);
  const ViewSpec& view = spec.views[0];
  EXPECT_EQ(view.name, "b_one");
  EXPECT_EQ(view.camera->intrinsics.fx, 5.0);
  EXPECT_EQ(view.camera->intrinsics.fy, 6.0);
  EXPECT_EQ(view.camera->intrinsics.cx, 2.0);
  EXPECT_EQ(view.camera->intrinsics.cy, 1.5);
  EXPECT_EQ(*view.camera->width, 4);
  EXPECT_EQ(view.pose, PoseKind::kGuess);
  EXPECT_EQ(view.normals->encoding, NormalEncoding::kUnit);
  EXPECT_EQ(view.normals->axes, NormalAxes::kOpencv);
  EXPECT_EQ(spec.unit, "units");
  EXPECT_THAT(spec.notes, Contains(HasSubstr("no depth map: two.jpg")));
  EXPECT_THAT(spec.notes, Contains(HasSubstr("by 0 % (median of 1)")));
  const auto shifted = read_colmap_workspace(folder_.path(), {0.5});
  EXPECT_EQ(shifted->views[0].camera->intrinsics.cx, 1.5);
  EXPECT_EQ(shifted->views[0].camera->intrinsics.cy, 1.0);
}

TEST_F(ColmapWorkspace, FallsBackToPhotometricAndLeavesOutEmptyMaps) {
  write_depth("b/one.jpg.geometric.bin", 0.0f);
  write_depth("two.jpg.photometric.bin");
  const auto spec = value_of(read_colmap_workspace(folder_.path()));
  ASSERT_EQ(spec.views.size(), 1u);
  EXPECT_EQ(spec.views[0].depth->file.filename(), "two.jpg.photometric.bin");
  EXPECT_FALSE(spec.views[0].normals);
  EXPECT_THAT(spec.notes, Contains(HasSubstr("depth map is empty: b/one.jpg")));
  EXPECT_THAT(spec.notes, Contains(HasSubstr("photometric depth map")));
}

TEST_F(ColmapWorkspace, ErrorsNameTheRemedy) {
  EXPECT_THAT(read_colmap_workspace(folder_.path()),
              HasError("none of the 2 images of the model has a depth map"));
  EXPECT_THAT(read_colmap_workspace(folder_ / "stereo"), HasError("no workspace of COLMAP"));
  folder_.write("stereo/depth_maps/two.jpg.geometric.bin", "4&3&1&");
  EXPECT_THAT(read_colmap_workspace(folder_.path()), HasError("two.jpg.geometric.bin"));
  folder_.write("stereo/depth_maps/two.jpg.geometric.bin",
                array_bytes("1&1&3&", {1.0f, 1.0f, 1.0f}));
  EXPECT_THAT(read_colmap_workspace(folder_.path()), HasError("one channel"));
}

TEST_F(ColmapWorkspace, TakesColoursOfTheSameSize) {
  fs::create_directories(folder_ / "images");
  write_depth("two.jpg.geometric.bin");
  folder_.write("images/two.jpg", "P6 4 3 255\n");
  EXPECT_TRUE(read_colmap_workspace(folder_.path())->views[0].colour);
  folder_.write("images/two.jpg", "P6 8 6 255\n");
  const auto spec = read_colmap_workspace(folder_.path());
  EXPECT_FALSE(spec->views[0].colour);
  EXPECT_THAT(spec->notes, Contains(HasSubstr("another size")));
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 1.0 : values[values.size() / 2];
}

// The median disagreement of the depth maps of a workspace with the maps of the next view.
double disagreement(const ProjectSpec& spec) {
  std::vector<double> all;
  for (std::size_t i = 4; i < 22; ++i) {
    const auto depth = read_colmap_array(spec.views[i].depth->file).value();
    const auto next = read_colmap_array(spec.views[i + 1].depth->file).value();
    const Camera camera =
        Camera::pinhole(depth.width, depth.height, spec.views[i].camera->intrinsics);
    std::vector<Eigen::Vector3d> points;
    for (int v = 0; v < depth.height; ++v)
      for (int u = 0; u < depth.width; ++u)
        if (depth(u, v) > 0.0f)
          points.push_back(spec.views[i].world_from_view * camera.ray(u, v).at(depth(u, v)));
    const auto differences = depth_differences(next, spec.views[i + 1].camera->intrinsics,
                                               spec.views[i + 1].world_from_view, points);
    all.insert(all.end(), differences.begin(), differences.end());
  }
  return median(all);
}

TEST(ColmapWorkspaceOnRealData, DepthMapsAgreeWithEachOther) {
  RELIEF_REQUIRE_TEST_DATA(folder, "formats/colmap/dense");
  const auto spec = value_of(read_colmap_workspace(folder));
  ASSERT_EQ(spec.views.size(), 28u);
  EXPECT_EQ(spec.views[9].name, "image010");
  for (const auto& view : spec.views) EXPECT_TRUE(view.normals) << view.name;
  EXPECT_THAT(spec.notes, Contains(HasSubstr("sparse points")));
  // The pixel centre of the stereo step is 0, not the 0.5 of the images.
  const double by_default = disagreement(spec);
  EXPECT_LT(by_default, 0.02);
  EXPECT_LT(by_default, disagreement(*read_colmap_workspace(folder, {0.5})));
  EXPECT_LT(by_default, disagreement(*read_colmap_workspace(folder, {-0.5})));
}

}  // namespace
}  // namespace relief
