// Which images of a folder are depth maps, and of what values.
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/images/image_io.h"
#include "scan/io/project/loading/view_loader.h"
#include "scan/io/workspaces/rgbd/rgbd_folder.h"
#include "tests/scan/io/small_files.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

const RgbdOptions kCamera{PinholeIntrinsics{5, 5, 1.5, 1}, {}};

Image depths(int channels, double max_value) {
  Image image(4, 3, channels, max_value);
  for (std::size_t i = 0; i < image.samples.size(); ++i)
    image.samples[i] = 100.0f + static_cast<float>(i / static_cast<std::size_t>(channels));
  return image;
}

class DepthImages : public ::testing::Test {
 protected:
  Result<ProjectSpec> read() const { return read_rgbd_folder(folder_.path(), kCamera); }

  TemporaryFolder folder_;
};

TEST_F(DepthImages, PicturesBesideThemAreLeftOut) {
  for (const std::string number : {"0", "1"}) {
    folder_.write("depth/depth_" + number + ".png", encode_png(depths(1, 65535)).value());
    folder_.write("depth/depth_vis_" + number + ".png", encode_png(depths(1, 255)).value());
    folder_.write("depth/depth_color_" + number + ".png", encode_png(depths(3, 255)).value());
  }
  folder_.write("trajectory.txt", "0 0 0 0 0 0 1\n1 0 0 0 0 0 1\n");
  const auto spec = value_of(read());
  ASSERT_EQ(spec.views.size(), 2u);
  EXPECT_EQ(spec.views[1].name, "depth_1");
  EXPECT_EQ(spec.views[1].world_from_view.translation().x(), 1.0);
  EXPECT_THAT(spec.notes, Contains(HasSubstr("4 images beside the depth maps are left out")));
}

TEST_F(DepthImages, PicturesBesideArraysAreLeftOut) {
  folder_.write("depth/0.npy", testing::npy_array("(1, 2)", {1.0, 2.0}));
  folder_.write("depth/0.png", encode_png(depths(3, 255)).value());
  const auto spec = value_of(read());
  ASSERT_EQ(spec.views.size(), 1u);
  EXPECT_EQ(spec.views[0].depth->file.filename(), "0.npy");
}

TEST_F(DepthImages, OfThreeEqualChannelsHaveOne) {
  folder_.write("depth/0.png", encode_png(depths(3, 65535)).value());
  const auto spec = value_of(read());
  EXPECT_EQ(spec.views[0].depth->scale, 0.001);
  EXPECT_EQ(value_of(read_depth_image(folder_ / "depth/0.png")).samples, depths(1, 65535).samples);
  Image coloured = depths(3, 65535);
  coloured(2, 1, 1) += 1.0f;
  folder_.write("depth/0.png", encode_png(coloured).value());
  EXPECT_THAT(read(), HasError("0.png", "this image has three colours"));
}

TEST_F(DepthImages, OfEightBitsNeedAScale) {
  folder_.write("depth/0.png", encode_png(depths(1, 255)).value());
  EXPECT_THAT(read(), HasError("0.png", "has 8 bits a pixel", "--depth-scale N"));
  EXPECT_THAT(read_rgbd_folder(folder_.path(), {kCamera.intrinsics, 100.0}), IsOk());
}

TEST_F(DepthImages, ThatCannotBeReadAreNamed) {
  folder_.write("depth/0.png", testing::png_head(4));
  EXPECT_THAT(read(), HasError("depth/0.png"));
}

// Centre, and what is no quaternion of length 1.
TEST_F(DepthImages, HaveNoPosesInListsOfBoxes) {
  for (const char* name : {"depth/0.png", "depth/1.png"})
    folder_.write(name, encode_png(depths(1, 65535)).value());
  folder_.write("groundtruth_cameras.txt", "0 0 0 0 0 0 1\n1 0 0 0 0 0 1\n");
  folder_.write("groundtruth_objects.txt",
                "-1.53 0.46 0.28 3.1 0.4 0.22 0.27\n1 1 1 0 0.5 0.2 0.3\n");
  EXPECT_EQ(value_of(read()).views[1].world_from_view.translation().x(), 1.0);
}

}  // namespace
}  // namespace relief
