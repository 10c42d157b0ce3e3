#include "scan/io/clouds/files/ptx_file.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/files/atomic_file.h"
#include "scan/io/grids/grid_view.h"
#include "tests/support/limited_memory.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_data.h"

namespace relief {
namespace {

using ::testing::HasSubstr;
using testing::LimitedMemory;
using testing::TemporaryFolder;

const std::string kIdentityMatrix = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
// A quarter turn about z and a translation, for row vectors.
const std::string kQuarterTurn = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n";
const std::string kPoints = "1 0 -1 0.25\n1 0 0 0.5\n0 0 0 0.5\n2 0 -1 0\n2 0 0 1\n2 0 1 1\n";

// Two columns of three points.
std::string scan_text(const std::string& matrix, const std::string& points = kPoints) {
  return "2\n3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n" + matrix + points;
}

auto parse(const std::string& content, int scan = 0) {
  return parse_ptx_scan(content, "a.ptx", scan);
}

TEST(PtxFile, ReadsColumnsFromTheBottom) {
  const auto grid = value_of(parse_ptx_scan(scan_text(kQuarterTurn), "a.ptx", 0));
  ASSERT_EQ(grid.points.width(), 2);
  ASSERT_EQ(grid.points.height(), 3);
  EXPECT_EQ(grid.points(0, 2), Eigen::Vector3d(1, 0, -1));
  EXPECT_EQ(grid.points(0, 1), Eigen::Vector3d(1, 0, 0));
  EXPECT_FALSE(grid.points(0, 0).allFinite());
  EXPECT_EQ(grid.points(1, 0), Eigen::Vector3d(2, 0, 1));
}

TEST(PtxFile, TheLastLineOfTheMatrixIsTheTranslation) {
  const auto grid = value_of(parse_ptx_scan(scan_text(kQuarterTurn), "a.ptx", 0));
  ASSERT_TRUE(grid.world_from_view.has_value());
  const Eigen::Vector3d in_world = *grid.world_from_view * Eigen::Vector3d(1, 0, -1);
  EXPECT_LT((in_world - Eigen::Vector3d(10, 21, 29)).norm(), 1e-12);
}

TEST(PtxFile, AnIdentityMatrixIsNoPose) {
  const auto grid = value_of(parse_ptx_scan(scan_text(kIdentityMatrix), "a.ptx", 0));
  EXPECT_FALSE(grid.world_from_view.has_value());
  EXPECT_TRUE(grid.notes.empty());
  std::string moved = scan_text(kIdentityMatrix);
  moved.replace(4, 5, "1 2 3");
  const auto noted = value_of(parse_ptx_scan(moved, "a.ptx", 0));
  EXPECT_FALSE(noted.world_from_view.has_value());
  ASSERT_EQ(noted.notes.size(), 1u);
  EXPECT_THAT(noted.notes[0], HasSubstr("the scanner stands at 1.0"));
}

TEST(PtxFile, AppliesTheMatrixWhereAsked) {
  const std::string scaled = "1 0 0 0\n0 1 0 0\n0 0 2 0\n10 20 30 1\n";
  const auto grid = value_of(parse_ptx_scan(scan_text(scaled), "a.ptx", 0, PtxMatrix::kApply));
  EXPECT_EQ(grid.points(0, 2), Eigen::Vector3d(11, 20, 28));
  EXPECT_FALSE(grid.points(0, 0).allFinite());
  EXPECT_FALSE(grid.world_from_view.has_value());
}

TEST(PtxFile, IntensitiesBecomeGreyAndColoursStay) {
  const auto grey = value_of(parse_ptx_scan(scan_text(kIdentityMatrix), "a.ptx", 0));
  EXPECT_EQ(grey.colours(0, 2), (Colour{64, 64, 64}));
  EXPECT_EQ(grey.colours(1, 0), (Colour{255, 255, 255}));
  std::string rgb;
  for (int i = 0; i < 6; ++i) rgb += "1 2 3 0.5 10 20 " + std::to_string(30 + i) + "\r\n";
  const auto coloured = value_of(parse_ptx_scan(scan_text(kIdentityMatrix, rgb), "a.ptx", 0));
  EXPECT_EQ(coloured.colours(0, 2), (Colour{10, 20, 30}));
  EXPECT_EQ(coloured.colours(1, 0), (Colour{10, 20, 35}));
}

TEST(PtxFile, AnIntensityThatIsTheSameEverywhereIsNoColour) {
  std::string points;
  for (int i = 0; i < 6; ++i) points += "1 2 3 0.5\n";
  const auto grid = value_of(parse_ptx_scan(scan_text(kIdentityMatrix, points), "a.ptx", 0));
  EXPECT_TRUE(grid.colours.empty());
}

TEST(PtxFile, ReadsEachOfSeveralScans) {
  const std::string content = scan_text(kIdentityMatrix) + scan_text(kQuarterTurn) + "\n";
  EXPECT_EQ(list_ptx_scans(content, "a.ptx")->size(), 2u);
  EXPECT_FALSE(parse_ptx_scan(content, "a.ptx", 0)->world_from_view.has_value());
  EXPECT_TRUE(parse_ptx_scan(content, "a.ptx", 1)->world_from_view.has_value());
  EXPECT_THAT(parse(content, 2), HasError("a.ptx: there is no scan 2; it holds 2"));
  EXPECT_THAT(parse(content, -1), HasError("no scan -1"));
}

TEST(PtxFile, AScanIsReadFromItsPlace) {
  const TemporaryFolder folder;
  const std::string second = scan_text(kQuarterTurn);
  const auto path = folder.write("a.ptx", "\xEF\xBB\xBF" + scan_text(kIdentityMatrix) + "\n\n" +
                                              second + scan_text(kIdentityMatrix));
  const auto scans = value_of(list_ptx_scans(path));
  ASSERT_EQ(scans.size(), 3u);
  EXPECT_FALSE(scans[0].has_pose);
  EXPECT_TRUE(scans[1].has_pose);
  for (int i = 0; i < 3; ++i) {
    const auto there = value_of(read_ptx_scan(path, scans[static_cast<std::size_t>(i)]));
    const auto all = value_of(read_ptx_scan(path, i));
    EXPECT_EQ(there.points(0, 2), all.points(0, 2));
    EXPECT_EQ(there.world_from_view.has_value(), all.world_from_view.has_value());
  }
  std::string changed = value_of(read_file(path));
  changed.replace(changed.rfind("2 0 -1 0\n"), 8, "2 0 -x 0");
  const auto damaged = folder.write("b.ptx", changed);
  EXPECT_THAT(read_ptx_scan(damaged, scans[2]), HasError("line 48: '-x' is no number"));
  PtxScan beyond = scans[2];
  beyond.end += 100;
  EXPECT_THAT(read_ptx_scan(path, beyond), HasError("got shorter"));
}

TEST(PtxFile, NamesTheLineAndTheRemedy) {
  EXPECT_THAT(parse("two\n3\n"), HasError("a.ptx: line 1: 'two' is no number of columns"));
  EXPECT_THAT(parse("2\n0\n"), HasError("line 2: '0' is no number of rows"));
  EXPECT_THAT(parse("2\n3\n0 0\n"), HasError("line 3: '' is no finite number"));
  EXPECT_THAT(parse("2\n3\n0 0 0 0\n"), HasError("line 3: expected 3 numbers"));
  EXPECT_THAT(parse("2\n3\n0 0 0\n"), HasError("7 lines of the scan's header are missing"));
  EXPECT_THAT(parse(""), HasError("before the number of columns"));
  EXPECT_THAT(parse(scan_text("2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1\n")),
              HasError("a.ptx: line 7: ", "scale", "export the scan again"));
  std::string changed = scan_text(kIdentityMatrix);
  changed.replace(changed.find("2 0 -1 0\n"), 8, "2 0 x 0");
  EXPECT_THAT(parse(changed), HasError("line 14: 'x' is no number"));
  changed.replace(changed.find("2 0 x 0\n"), 7, "2 0 0 0 1");
  EXPECT_THAT(parse(changed), HasError("line 14: a point has 3, 4 or 7 numbers"));
  changed.replace(changed.find("2 0 0 0 1\n"), 9, "2 0 0 0 1 2 300");
  EXPECT_THAT(parse(changed), HasError("line 14: red, green and blue are numbers from 0"));
  changed.replace(changed.find("2 0 0 0 1 2 300\n"), 15, "2 0 0");
  EXPECT_THAT(parse(changed), HasError("line 14: 3 numbers, but the points before have 4"));
}

TEST(PtxFile, SaysHowManyLinesAreMissing) {
  const std::string content = scan_text(kIdentityMatrix, "1 0 -1 0.25\n1 0 0 0.5\n");
  EXPECT_THAT(parse(content), HasError("begins in line 1 is truncated: 2 columns of 3 points "
                                       "promised, 4 lines missing"));
  EXPECT_THAT(list_ptx_scans(content, "a.ptx"), HasError("4 lines missing"));
}

TEST(PtxFile, AHeaderAloneTakesNoMemory) {
  const LimitedMemory limit(std::size_t{1} << 28);
  std::string content = scan_text(kIdentityMatrix);
  content.replace(0, 3, "2147483647\n2147483647");
  EXPECT_THAT(parse(content), HasError("lines missing"));
}

TEST(PtxFile, DamagedFilesNeverCrash) {
  const std::string content = scan_text(kQuarterTurn) + scan_text(kIdentityMatrix);
  const LimitedMemory limit(std::size_t{1} << 28);
  // The last number may be cut.
  for (std::size_t size = 0; size + 3 < content.size(); ++size)
    EXPECT_THAT(parse_ptx_scan(content.substr(0, size), "a.ptx", 1), HasError()) << size;
  std::mt19937 random(3);
  for (int k = 0; k < 3000; ++k) {
    std::string changed = content;
    changed[random() % changed.size()] =
        static_cast<char>(random() % 3 ? random() % 256 : '0' + random() % 10);
    (void)parse_ptx_scan(changed, "a.ptx", static_cast<int>(random() % 3));
    (void)list_ptx_scans(changed, "a.ptx");
  }
}

RangeView sphere_view(double x) {
  const auto pose = testing::look_at({x, -7.0 / 3.0, 1.0}, {0, 0, 0});
  return testing::render(testing::sphere({0, 0, 0}, 1.0),
                         Camera::pinhole(40, 30, {50, 50, 19.5, 14.5}), pose);
}

void expect_same_points(const RangeView& view, const GridFile& grid) {
  ASSERT_EQ(grid.points.width(), view.width());
  ASSERT_EQ(grid.points.height(), view.height());
  std::size_t samples = 0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      ASSERT_EQ(grid.points(u, v).allFinite(), view.has_sample(u, v));
      if (!view.has_sample(u, v)) continue;
      ASSERT_EQ(grid.points(u, v), view.point(u, v));
      ++samples;
    }
  }
  EXPECT_GT(samples, 100u);
}

TEST(PtxFile, WritesWhatItReads) {
  const TemporaryFolder folder;
  std::vector<RangeView> views{sphere_view(0.1), sphere_view(0.7)};
  views[1].colours = Grid<Colour>(40, 30);
  for (std::size_t i = 0; i < views[1].colours.size(); ++i)
    views[1].colours[i] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 7), 3};
  ASSERT_THAT(write_ptx(views, folder / "a.ptx"), IsOk());
  EXPECT_EQ(list_ptx_scans(folder / "a.ptx")->size(), 2u);
  for (int i = 0; i < 2; ++i) {
    const RangeView& view = views[static_cast<std::size_t>(i)];
    const auto grid = value_of(read_ptx_scan(folder / "a.ptx", i));
    expect_same_points(view, grid);
    ASSERT_TRUE(grid.world_from_view.has_value());
    EXPECT_LT((grid.world_from_view->matrix() - view.world_from_view.matrix()).norm(), 1e-14);
    EXPECT_EQ(grid.colours.empty(), i == 0);
  }
  const auto coloured = read_ptx_scan(folder / "a.ptx", 1);
  for (std::size_t i = 0; i < views[1].range.size(); ++i) {
    if (views[1].range[i] == views[1].range[i]) {
      ASSERT_EQ(coloured->colours[i], views[1].colours[i]);
    }
  }
}

TEST(PtxFile, WritesMetres) {
  const TemporaryFolder folder;
  const RangeView view = sphere_view(0.1);
  ASSERT_THAT(write_ptx({view}, folder / "a.ptx", 1e-3), IsOk());
  const auto grid = value_of(read_ptx_scan(folder / "a.ptx", 0));
  std::size_t samples = 0;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      ++samples;
      EXPECT_LT((1e3 * grid.points(u, v) - view.point(u, v)).norm(), 1e-12);
    }
  EXPECT_GT(samples, 100u);
  EXPECT_LT((1e3 * grid.world_from_view->translation() - view.world_from_view.translation()).norm(),
            1e-12);
}

TEST(PtxFile, WritesWholeFilesOrNone) {
  const TemporaryFolder folder;
  EXPECT_THAT(write_ptx({}, folder / "a.ptx"), HasError());
  EXPECT_THAT(write_ptx({RangeView{}}, folder / "a.ptx"), HasError());
  EXPECT_THAT(write_ptx({sphere_view(0.1)}, folder / "no" / "a.ptx"),
              HasError(ErrorKind::kCannotWrite));
  EXPECT_EQ(folder.size(), 0u);
}

TEST(PtxFile, ReadsRealFiles) {
  RELIEF_REQUIRE_TEST_DATA(path, "formats/ptx");
  const auto coloured = value_of(read_ptx_scan(path / "1.2-with-color.ptx", 0));
  EXPECT_EQ(coloured.points.width(), 15);
  EXPECT_EQ(coloured.points.height(), 71);
  EXPECT_EQ(coloured.points(0, 70), Eigen::Vector3d(637012.24, 849028.31, 431.66));
  EXPECT_EQ(coloured.colours(0, 70), (Colour{68, 77, 88}));
  const auto moved = value_of(read_ptx_scan(path / "complex-transform.ptx", 0));
  ASSERT_TRUE(moved.world_from_view.has_value());
  EXPECT_EQ(moved.world_from_view->translation(), Eigen::Vector3d(-3.028748, -3.819741, -1.384333));
  EXPECT_EQ(moved.points(0, 1), Eigen::Vector3d(-0.005630, 0.645218, -0.440506));
  const auto row = value_of(read_ptx_scan(path / "no-color.ptx", 0));
  EXPECT_EQ(row.points.height(), 1);
}

TEST(PtxFile, RefusesTheScaleOfARealFile) {
  RELIEF_REQUIRE_TEST_DATA(path, "formats/ptx/multiple-and-transform.ptx");
  EXPECT_EQ(list_ptx_scans(path)->size(), 2u);
  EXPECT_THAT(read_ptx_scan(path, 0), HasError("line 7: "));
  const auto applied = value_of(read_ptx_scan(path, 0, PtxMatrix::kApply));
  EXPECT_LT((applied.points(0, 1) - Eigen::Vector3d(637012.24, 849028.31, 431.66)).norm(), 1e-6);
  EXPECT_THAT(read_ptx_scan(path, 1), IsOk());
}

}  // namespace
}  // namespace relief
