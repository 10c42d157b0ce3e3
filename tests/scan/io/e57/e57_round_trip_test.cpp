// Views written as E57 and read again, damaged files, and files of other programs.
#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/e57/e57_file.h"
#include "tests/scan/io/e57/e57_builder.h"
#include "tests/support/limited_memory.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_data.h"

namespace relief {
namespace {

using testing::LimitedMemory;
using testing::TemporaryFolder;

// A sphere before a camera that stands anywhere, with colours.
RangeView sphere_view(int width, int height) {
  const Camera camera = Camera::pinhole(
      width, height, {1.7 * width, 1.7 * width, (width - 1) / 2.0, (height - 1) / 2.0});
  const RigidMotion pose = testing::look_at({1, 2, -3}, {0.1, 0.2, 10});
  RangeView view =
      testing::render(testing::sphere(pose * Eigen::Vector3d(0, 0, 9), 2.5), camera, pose);
  view.name = "sphere <1> & \xc3\xa9 ]]>";
  view.colours = Grid<Colour>(width, height);
  for (std::size_t i = 0; i < view.colours.size(); ++i)
    view.colours[i] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i * 7),
                       static_cast<std::uint8_t>(i >> 4)};
  return view;
}

void expect_same_samples(const GridFile& grid, const RangeView& view) {
  ASSERT_EQ(grid.points.width(), view.width());
  ASSERT_EQ(grid.points.height(), view.height());
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      ASSERT_EQ(grid.points(u, v).allFinite(), view.has_sample(u, v));
      if (!view.has_sample(u, v)) continue;
      ASSERT_EQ(grid.points(u, v), view.point(u, v));
      if (view.has_normals()) {
        ASSERT_EQ(grid.normals(u, v), view.normals(u, v));
      }
      if (!view.colours.empty()) {
        ASSERT_EQ(grid.colours(u, v), view.colours(u, v));
      }
    }
  }
}

class E57RoundTripOfWidth : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Widths, E57RoundTripOfWidth, ::testing::Values(2, 9, 150),
                         ::testing::PrintToStringParamName());

TEST_P(E57RoundTripOfWidth, SamplesAreTheSameToTheLastBit) {
  const TemporaryFolder folder;
  RangeView view = sphere_view(GetParam(), GetParam() + 3);
  RangeView plain = view;
  plain.normals = {};
  plain.colours = {};
  plain.pose = PoseKind::kAbsent;
  ASSERT_THAT(write_e57({view, plain}, folder / "a.e57"), IsOk());
  const auto first = value_of(read_e57_scan(folder / "a.e57", 0));
  expect_same_samples(first, view);
  ASSERT_TRUE(first.world_from_view.has_value());
  EXPECT_TRUE(first.world_from_view->isApprox(view.world_from_view, 1e-15));
  EXPECT_TRUE(first.notes.empty());
  const auto second = value_of(read_e57_scan(folder / "a.e57", 1));
  expect_same_samples(second, plain);
  EXPECT_TRUE(second.normals.empty());
  EXPECT_TRUE(second.colours.empty());
  EXPECT_FALSE(second.world_from_view.has_value());
  EXPECT_EQ(list_e57_scans(folder / "a.e57")->front().name, view.name);
}

TEST(E57RoundTrip, ANormalThatIsMissingStaysMissing) {
  RangeView view = sphere_view(9, 9);
  view.normals(4, 4).setConstant(static_cast<float>(kNoSample));
  const auto grid = value_of(parse_e57_scan(*encode_e57({view}), "a.e57", 0));
  EXPECT_TRUE(std::isnan(grid.normals(4, 4).x()));
  EXPECT_EQ(grid.normals(5, 4), view.normals(5, 4));
}

TEST(E57RoundTrip, UnitsBecomeMetres) {
  const RangeView view = sphere_view(9, 9);
  const auto grid = value_of(parse_e57_scan(*encode_e57({view}, 0.5), "a.e57", 0));
  EXPECT_EQ(grid.points(4, 4), view.point(4, 4) * 0.5);
  EXPECT_EQ(grid.world_from_view->translation(), view.world_from_view.translation() * 0.5);
  for (const double scale : {0.0, -1.0, kNoSample, HUGE_VAL})
    EXPECT_THAT(encode_e57({view}, scale), HasError("must be a positive number"));
}

TEST(E57RoundTrip, BytesDependOnTheViewsAlone) {
  const RangeView view = sphere_view(20, 20);
  const std::string content = *encode_e57({view, view});
  EXPECT_EQ(content, *encode_e57({view, view}));
  const auto scans = *parse_e57_scans(content, "a.e57");
  EXPECT_NE(scans[0].guid, scans[1].guid);
  EXPECT_EQ(scans[0].guid.size(), 38u);
}

TEST(E57RoundTrip, ViewsWithoutSamplesAndNamesThatAreNoText) {
  RangeView view = sphere_view(5, 5);
  for (double& range : view.range) range = kNoSample;
  view.name =
      "a\x01\xff"
      "b";
  const std::string content = *encode_e57({view});
  const auto scans = value_of(parse_e57_scans(content, "a.e57"));
  EXPECT_EQ(scans.front().name, "a__b");
  EXPECT_EQ(scans.front().points, 0u);
  EXPECT_TRUE(parse_e57_cloud(content, "a.e57", 0)->points.empty());
  EXPECT_TRUE(parse_e57_scans(*encode_e57({}), "a.e57")->empty());
}

TEST(E57RoundTrip, AFileThatCannotBeWrittenIsAnError) {
  const TemporaryFolder folder;
  EXPECT_THAT(write_e57({sphere_view(3, 3)}, folder / "no/such/a.e57"),
              HasError(ErrorKind::kCannotWrite));
}

TEST(E57Damage, ATruncatedFileIsAnError) {
  const std::string content = *encode_e57({sphere_view(6, 5)});
  ASSERT_THAT(parse_e57_cloud(content, "a.e57", 0), IsOk());
  for (std::size_t size = 0; size < content.size(); ++size)
    EXPECT_THAT(parse_e57_cloud(content.substr(0, size), "a.e57", 0), HasError()) << size;
}

TEST(E57Damage, AChangedByteIsAnError) {
  const std::string content = *encode_e57({sphere_view(6, 5)});
  std::mt19937 random(1);
  for (int k = 0; k < 500; ++k) {
    std::string changed = content;
    const std::size_t at = random() % changed.size();
    changed[at] = static_cast<char>(changed[at] ^ (1 + random() % 255));
    EXPECT_THAT(parse_e57_cloud(changed, "a.e57", 0), HasError()) << at;
  }
}

// What the checksums do not catch.
TEST(E57Damage, ChangesWithRightChecksumsNeverCrash) {
  const LimitedMemory limit(std::size_t{1} << 30);
  const std::string content = *encode_e57({sphere_view(6, 5)});
  std::mt19937 random(2);
  for (int k = 0; k < 20000; ++k) {
    std::string changed = content;
    for (std::size_t changes = 1 + random() % 4; changes > 0; --changes)
      changed[random() % changed.size()] =
          static_cast<char>(random() % 3 ? random() % 256 : '0' + random() % 10);
    (void)parse_e57_scan(testing::with_checksums(changed), "a.e57", 0);
  }
}

struct RealFile {
  const char* path;
  std::size_t points;
};

TEST(E57RealFiles, ReadAsOtherProgramsReadThem) {
  RELIEF_REQUIRE_TEST_DATA(folder, "formats/e57");
  for (const RealFile& file : {RealFile{"A4.e57", 4},
                               {"cry-inc/testdata/tiny_spherical.e57", 180},
                               {"cry-inc/testdata/tinyCartesianFloatRgb.e57", 2090},
                               {"cry-inc/testdata/cartesian_invalid_state_single.e57", 1},
                               {"cry-inc/testdata/read_error.e57", 0},
                               {"cry-inc/testdata/las2e57_no_images_tag.e57", 153},
                               {"libE57Format-test-data/self/ZeroPointsInvalid.e57", 0},
                               {"libE57Format-test-data/self/ColouredCubeDouble.e57", 7680},
                               {"libE57Format-test-data/reference/bunnyInt32.e57", 30571}}) {
    const auto cloud = value_of(read_e57_cloud(folder / file.path, 0));
    EXPECT_EQ(cloud.points.size(), file.points) << file.path;
  }
  const auto normals = read_e57_cloud(folder / "pye57/tests/test_data/testWithNormals.e57", 0);
  ASSERT_THAT(normals, IsOk());
  EXPECT_EQ(normals->normals.size(), 2u);
  EXPECT_EQ(list_e57_scans(folder / "A_moved_B.e57")->size(), 2u);
}

TEST(E57RealFiles, DamagedOnesNameTheirDamage) {
  RELIEF_REQUIRE_TEST_DATA(folder, "formats/e57");
  const auto error = [&](const std::string& path) { return read_e57_cloud(folder / path, 0); };
  EXPECT_THAT(error("cry-inc/testdata/corrupt_crc.e57"), HasError("page 33 (from byte 33792)"));
  EXPECT_THAT(error("libE57Format-test-data/self/bad-crc.e57"), HasError("page 0 (from byte 0)"));
  EXPECT_THAT(error("libE57Format-test-data/self/InvalidCVHeader.e57"),
              HasError("byte 48 (page 0): a section of points begins with 1, not with 182"));
  EXPECT_THAT(error("cry-inc/testdata/empty.e57"), HasError("holds no scans"));
}

// One bunny in five encodings: each differs from the exact one by its own rounding.
TEST(E57RealFiles, OneCloudInSeveralEncodings) {
  RELIEF_REQUIRE_TEST_DATA(folder, "formats/e57");
  const auto exact =
      value_of(read_e57_cloud(folder / "libE57Format-test-data/reference/bunnyDouble.e57", 0));
  const auto largest_difference = [&](const std::string& path) {
    const auto other = value_of(read_e57_cloud(folder / path, 0));
    EXPECT_EQ(other.points.size(), exact.points.size());
    double largest = 0.0;
    for (std::size_t i = 0; i < exact.points.size(); ++i)
      largest = std::max(largest, (other.points[i] - exact.points[i]).cwiseAbs().maxCoeff());
    return largest;
  };
  EXPECT_LT(largest_difference("cry-inc/testdata/bunnyFloat.e57"), 0.2 * 0x1p-24);
  const double micrometre = 1e-6;  // the scale of the integers; the points are multiples of it
  for (const char* name :
       {"cry-inc/testdata/bunnyInt19.e57", "cry-inc/testdata/bunnyInt21.e57",
        "cry-inc/testdata/bunnyInt24.e57", "libE57Format-test-data/reference/bunnyInt32.e57"})
    EXPECT_LT(largest_difference(name), 1e-6 * micrometre) << name;
}

TEST(E57RealFiles, AStructuredScanHasItsGrid) {
  RELIEF_REQUIRE_TEST_DATA(path, "formats/e57/pye57/tests/test_data/pumpAVisualReferenceImage.e57");
  const auto grid = value_of(read_e57_scan(path, 0));
  EXPECT_EQ(grid.points.width(), 345);
  EXPECT_EQ(grid.points.height(), 1074);
  std::size_t samples = 0;
  for (const auto& point : grid.points) samples += point.allFinite();
  EXPECT_EQ(samples, 155201u);
  EXPECT_EQ(grid.colours.size(), grid.points.size());
}

}  // namespace
}  // namespace relief
