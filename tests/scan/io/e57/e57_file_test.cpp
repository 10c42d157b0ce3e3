// What a scan means: points, invalid records, colours, normals, poses, grids.
#include "scan/io/e57/e57_file.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scan/io/e57/e57_builder.h"
#include "tests/support/limited_memory.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::bits;
using ::testing::Contains;
using testing::doubles;
using testing::E57Builder;
using ::testing::ElementsAre;
using testing::floats;
using ::testing::HasSubstr;
using testing::kRowColumn;
using testing::kXyz;
using testing::LimitedMemory;
using testing::TemporaryFolder;

std::string scan_file(const std::string& prototype, std::uint64_t count,
                      const std::vector<std::string>& streams, const std::string& extra = "",
                      const std::string& attributes = "") {
  E57Builder builder;
  builder.add_scan(prototype, count, streams, extra);
  return builder.finish(attributes);
}

Result<E57Cloud> cloud(const std::string& content) { return parse_e57_cloud(content, "a.e57", 0); }
Result<GridFile> grid(const std::string& content) { return parse_e57_scan(content, "a.e57", 0); }

TEST(E57Cloud, ReadsCartesianPoints) {
  const auto read =
      value_of(cloud(scan_file(kXyz, 2, {doubles({1, 0.1}), doubles({2, 0.2}), doubles({3, 0.3})},
                               "<name>left <![CDATA[& right]]></name><guid>{1}</guid>")));
  EXPECT_THAT(read.points, ElementsAre(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0.1, 0.2, 0.3)));
  EXPECT_EQ(read.name, "left & right");
  EXPECT_EQ(read.guid, "{1}");
  EXPECT_FALSE(read.structured);
  EXPECT_FALSE(read.world_from_view.has_value());
  EXPECT_TRUE(read.notes.empty());
}

TEST(E57Cloud, ReadsSphericalPoints) {
  const double right_angle = std::numbers::pi / 2;
  const auto read = value_of(
      cloud(scan_file("<sphericalRange type=\"Float\"/><sphericalAzimuth type=\"Float\"/>"
                      "<sphericalElevation type=\"Float\"/>",
                      4,
                      {doubles({2, 2, 2, 2}), doubles({0, right_angle, 0, right_angle / 2}),
                       doubles({0, 0, right_angle, -right_angle / 2})})));
  EXPECT_EQ(read.points[0], Eigen::Vector3d(2, 0, 0));
  EXPECT_TRUE(read.points[1].isApprox(Eigen::Vector3d(0, 2, 0)));
  EXPECT_TRUE(read.points[2].isApprox(Eigen::Vector3d(0, 0, 2)));
  EXPECT_TRUE(read.points[3].isApprox(Eigen::Vector3d(1, 1, -std::sqrt(2.0))));
}

TEST(E57Cloud, LeavesOutInvalidRecordsAndCountsThem) {
  const auto read = value_of(cloud(
      scan_file(kXyz + "<cartesianInvalidState type=\"Integer\" minimum=\"0\" maximum=\"2\"/>", 6,
                {doubles({1, 2, 3, 0, NAN, 6}), doubles({1, 2, 3, 0, 0, 6}),
                 doubles({1, 2, 3, 0, 0, 6}), bits({0, 1, 2, 0, 0, 0}, 2)})));
  EXPECT_THAT(read.points, ElementsAre(Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(6, 6, 6)));
  EXPECT_THAT(read.notes, ElementsAre(HasSubstr("2 records that the scan calls invalid"),
                                      HasSubstr("1 points that are not finite"),
                                      HasSubstr("1 points exactly at")));
}

std::string coloured(const std::string& field_attributes, const std::string& stream,
                     const std::string& extra) {
  std::string prototype = kXyz;
  for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
    prototype += std::string("<") + name + " " + field_attributes + "/>";
  const std::string ones = doubles({1, 1, 1});
  return scan_file(prototype, 3, {ones, ones, ones, stream, stream, stream}, extra);
}

std::vector<int> reds(const std::string& content) {
  const auto read = value_of(cloud(content));
  std::vector<int> values;
  for (const Colour& colour : read.colours) values.push_back(colour[0]);
  return values;
}

TEST(E57Cloud, ScalesColoursToEightBits) {
  const std::string limits =
      "<colorLimits><colorRedMinimum/><colorRedMaximum>1000</colorRedMaximum>"
      "<colorGreenMinimum/><colorGreenMaximum>1000</colorGreenMaximum>"
      "<colorBlueMinimum/><colorBlueMaximum>1000</colorBlueMaximum></colorLimits>";
  const std::string wide = bits({0, 500, 2000}, 16);
  const std::string integer = "type=\"Integer\" minimum=\"0\" maximum=\"65535\"";
  EXPECT_THAT(reds(coloured(integer, wide, limits)), ElementsAre(0, 128, 255));
  EXPECT_THAT(reds(coloured(integer, bits({0, 0x8000, 0xffff}, 16), "")), ElementsAre(0, 128, 255));
  const std::string real = "type=\"Float\" precision=\"single\"";
  EXPECT_THAT(reds(coloured(real, floats({0, 0.2f, 1}), "")), ElementsAre(0, 51, 255));
  EXPECT_THAT(reds(coloured(real, floats({0, 51, 200}), "")), ElementsAre(0, 51, 200));
  EXPECT_THAT(reds(coloured(real, floats({NAN, INFINITY, -3}), limits)), ElementsAre(0, 255, 0));
}

TEST(E57Cloud, AnInvalidColourIsBlack) {
  std::string prototype = kXyz;
  for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
    prototype += std::string("<") + name + " type=\"Integer\" minimum=\"0\" maximum=\"255\"/>";
  prototype += "<isColorInvalid type=\"Integer\" minimum=\"0\" maximum=\"1\"/>";
  const std::string ones = doubles({1, 1}), eight = bits({9, 9}, 8);
  const auto read = value_of(
      cloud(scan_file(prototype, 2, {ones, ones, ones, eight, eight, eight, bits({0, 1}, 1)})));
  EXPECT_THAT(read.colours, ElementsAre(Colour{9, 9, 9}, Colour{0, 0, 0}));
}

TEST(E57Cloud, TakesIntensityAsGrey) {
  const auto greys = [](const std::string& values, const std::string& extra) {
    const std::string ones = doubles({1, 1, 1});
    return reds(
        scan_file(kXyz + "<intensity type=\"Float\"/>", 3, {ones, ones, ones, values}, extra));
  };
  const std::string limits =
      "<intensityLimits><intensityMinimum type=\"ScaledInteger\" scale=\"0.1\">-10"
      "</intensityMinimum><intensityMaximum>1</intensityMaximum></intensityLimits>";
  EXPECT_THAT(greys(doubles({-1, 0, 1}), limits), ElementsAre(0, 128, 255));
  EXPECT_THAT(greys(doubles({10, 12, 20}), ""), ElementsAre(0, 51, 255));
  EXPECT_THAT(greys(doubles({7, 7, 7}), ""), ElementsAre());
}

TEST(E57Cloud, FindsNormalsByTheirNamespace) {
  const std::string prototype = kXyz +
                                "<q:normalX type=\"Float\" precision=\"single\"/>"
                                "<q:normalY type=\"Float\" precision=\"single\"/>"
                                "<q:normalZ type=\"Float\" precision=\"single\"/>";
  const std::string ones = doubles({1, 1});
  const std::vector<std::string> streams{ones,           ones,           ones,
                                         floats({1, 0}), floats({0, 0}), floats({0, 0})};
  const auto read = value_of(cloud(scan_file(
      prototype, 2, streams, "", "xmlns:q=\"http://www.libe57.org/E57_NOR_surface_normals.txt\"")));
  ASSERT_EQ(read.normals.size(), 2u);
  EXPECT_EQ(read.normals[0], Eigen::Vector3f(1, 0, 0));
  EXPECT_TRUE(std::isnan(read.normals[1].x())) << "a vector of length 0 is no normal";
  EXPECT_TRUE(cloud(scan_file(prototype, 2, streams, "", "xmlns:q=\"other\""))->normals.empty());
}

std::string posed(const std::string& pose) {
  return scan_file(kXyz, 1, {doubles({1}), doubles({1}), doubles({1})},
                   "<pose>" + pose + "</pose>");
}

TEST(E57Cloud, ReadsPoses) {
  const std::string turn = "<rotation><w/><x/><y/><z>1</z></rotation>";
  const std::string shift = "<translation><x>1</x><y>2</y><z>3e+000</z></translation>";
  const auto both = value_of(cloud(posed(turn + shift)));
  EXPECT_TRUE(
      (*both.world_from_view * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0, 2, 3)));
  const auto moved = cloud(posed(shift));
  EXPECT_EQ(moved->world_from_view->linear(), Eigen::Matrix3d::Identity());
  EXPECT_EQ(moved->world_from_view->translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(cloud(posed(turn))->world_from_view->translation(), Eigen::Vector3d::Zero());
  const auto rounded = cloud(posed("<rotation><w>1.0005</w></rotation>"));
  EXPECT_EQ(rounded->world_from_view->linear(), Eigen::Matrix3d::Identity());
  EXPECT_THAT(
      cloud(posed("<rotation><w>1.01</w></rotation>")),
      HasError("scan 0 of the E57: the rotation of its pose is a quaternion of length 1.01"));
  EXPECT_THAT(cloud(posed("<translation><x>a</x></translation>")), HasError("x is 'a'"));
}

std::vector<std::string> grid_streams(const std::vector<double>& z,
                                      const std::vector<std::uint64_t>& rows,
                                      const std::vector<std::uint64_t>& columns) {
  const std::string zero = doubles(std::vector<double>(z.size(), 0.0));
  return {zero, zero, doubles(z), bits(rows, 8), bits(columns, 8)};
}

TEST(E57Grid, PutsAStructuredScanOnItsGrid) {
  const std::string bounds =
      "<indexBounds><rowMinimum>3</rowMinimum><rowMaximum>6</rowMaximum><columnMinimum>10"
      "</columnMinimum><columnMaximum>12</columnMaximum></indexBounds>";
  const auto streams = grid_streams({1, 2, 3}, {4, 5, 5}, {10, 10, 12});
  const auto told = value_of(grid(scan_file(kXyz + kRowColumn, 3, streams, bounds)));
  EXPECT_EQ(told.points.width(), 3);
  EXPECT_EQ(told.points.height(), 4);
  EXPECT_EQ(told.points(0, 1).z(), 1.0);
  EXPECT_EQ(told.points(0, 2).z(), 2.0);
  EXPECT_EQ(told.points(2, 2).z(), 3.0);
  EXPECT_FALSE(told.points(1, 1).allFinite());
  const auto found = value_of(grid(scan_file(kXyz + kRowColumn, 3, streams)));
  EXPECT_EQ(found.points.width(), 3);
  EXPECT_EQ(found.points.height(), 2);
  EXPECT_EQ(found.points(2, 1).z(), 3.0);
}

TEST(E57Grid, PointsOutsideOfTheIndexBoundsWiden) {
  const auto read =
      value_of(grid(scan_file(kXyz + kRowColumn, 2, grid_streams({1, 2}, {0, 4}, {0, 3}),
                              "<indexBounds><rowMinimum/><rowMaximum>2</rowMaximum><columnMinimum/>"
                              "<columnMaximum>2</columnMaximum></indexBounds>")));
  EXPECT_EQ(read.points.width(), 4);
  EXPECT_EQ(read.points.height(), 5);
  EXPECT_THAT(read.notes, Contains(HasSubstr("do not keep to the scan's indexBounds")));
}

TEST(E57Grid, KeepsTheNearestOfSeveralPoints) {
  const auto read = value_of(grid(
      scan_file(kXyz + kRowColumn, 4, grid_streams({5, 2, 3, 1}, {0, 0, 0, 1}, {0, 0, 0, 1}))));
  EXPECT_EQ(read.points(0, 0).z(), 2.0);
  EXPECT_THAT(read.notes, Contains(HasSubstr("2 points share their place")));
}

TEST(E57Grid, SaysThatAScanIsUnstructured) {
  const std::string one = doubles({1});
  EXPECT_THAT(grid(scan_file(kXyz, 1, {one, one, one})),
              HasError("a.e57: the scan of the E57 is unstructured"));
  const auto one_row = grid_streams({1, 2}, {7, 7}, {0, 1});
  EXPECT_THAT(grid(scan_file(kXyz + kRowColumn, 2, one_row)), HasError("unstructured"));
  EXPECT_THAT(grid(scan_file(kXyz + kRowColumn, 1, grid_streams({0}, {0}, {0}))),
              HasError("no valid points"));
}

TEST(E57Grid, AFewPointsTakeNoLargeGrid) {
  const LimitedMemory limit(std::size_t{1} << 28);
  const std::string indices =
      "<rowIndex type=\"Integer\" minimum=\"0\" maximum=\"65535\"/>"
      "<columnIndex type=\"Integer\" minimum=\"0\" maximum=\"65535\"/>";
  const std::string ones = doubles({1, 1}), ends = bits({0, 65535}, 16);
  EXPECT_THAT(grid(scan_file(kXyz + indices, 2, {ones, ones, ones, ends, ends})),
              HasError("is 65536x65536, but has only 2 points"));
  const std::string huge =
      "<rowIndex type=\"Integer\" minimum=\"0\" maximum=\"4294967295\"/>"
      "<columnIndex type=\"Integer\" minimum=\"0\" maximum=\"4294967295\"/>";
  const std::string far = bits({0, 4294967295}, 32), near = bits({0, 1 << 30}, 32);
  for (const std::string& end : {far, near}) {
    const auto read = value_of(cloud(scan_file(kXyz + huge, 2, {ones, ones, ones, end, end})));
    EXPECT_FALSE(read.structured);
    EXPECT_THAT(read.notes, Contains(HasSubstr("were left out")));
  }
}

TEST(E57Cloud, AHeaderAloneTakesNoMemory) {
  const LimitedMemory limit(std::size_t{1} << 28);
  const std::string one = doubles({1});
  EXPECT_THAT(cloud(scan_file(kXyz, 1ull << 40, {one, one, one})),
              HasError("the E57 promises 1099511627776 points of 192 bits each"));
  std::string constant = kXyz;
  for (std::size_t at; (at = constant.find("\"Float\"")) != std::string::npos;)
    constant.replace(at, 7, "\"Integer\" minimum=\"1\" maximum=\"1\"");
  EXPECT_THAT(cloud(scan_file(constant, 1ull << 60, {"", "", ""})),
              HasError("more than the file can hold"));
  EXPECT_EQ(cloud(scan_file(constant, 3, {"", "", ""}))->points.size(), 3u);
}

TEST(E57File, ListsAndReadsSeveralScans) {
  const TemporaryFolder folder;
  E57Builder builder;
  const std::string one = doubles({1}), two = doubles({2});
  builder.add_scan(kXyz, 1, {one, one, one}, "<name>a</name>");
  builder.add_scan(kXyz + "<intensity type=\"Float\"/>", 1, {two, two, two, one}, "<name>b</name>");
  const auto path = folder.write("a.e57", builder.finish());
  const auto scans = value_of(list_e57_scans(path));
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_EQ(scans[1].name, "b");
  EXPECT_EQ(scans[1].points, 1u);
  EXPECT_TRUE(scans[1].has_intensity);
  EXPECT_FALSE(scans[0].has_intensity || scans[0].has_indices || scans[0].has_normals);
  EXPECT_EQ(read_e57_cloud(path, 1)->points[0], Eigen::Vector3d(2, 2, 2));
  EXPECT_THAT(read_e57_cloud(path, 2), HasError("no scan 2; its scans are 0 to 1"));
  EXPECT_THAT(read_e57_cloud(path, -1), HasError("no scan -1"));
  EXPECT_THAT(read_e57_scan(folder / "missing.e57", 0), HasError("no such file"));
  EXPECT_THAT(read_e57_scan(folder.path(), 0), HasError("no such file"));
  EXPECT_THAT(cloud(E57Builder().finish()), HasError("holds no scans"));
}

TEST(E57Cloud, NeedsCoordinates) {
  EXPECT_THAT(cloud(scan_file("<intensity type=\"Float\"/>", 1, {doubles({1})})),
              HasError("neither the fields cartesianX"));
}

}  // namespace
}  // namespace relief
