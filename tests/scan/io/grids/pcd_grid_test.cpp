#include <cstring>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/grids/grid_file.h"
#include "tests/support/limited_memory.h"
#include "tests/support/parameter_names.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::LimitedMemory;
using testing::TemporaryFolder;

std::string header(const std::string& size, const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\n"
         "TYPE F F F F F F\nCOUNT 1 1 1 1 1 1\n" +
         size + "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 6\nDATA " + data + "\n";
}
const std::string kSize = "WIDTH 3\nHEIGHT 2\n";
const std::string kPoints =
    "0 0 1 0 0 -1\n1 0 1 0 0 -1\nnan nan nan nan nan nan\n0 1 1 0 0 -1\n1 1 2 0 0 -1\n2 1 3 0 0 "
    "-1\n";

std::string binary_points() {
  std::string bytes;
  for (int i = 0; i < 36; ++i) {
    const float value = static_cast<float>(i);
    bytes.append(reinterpret_cast<const char*>(&value), 4);
  }
  return bytes;
}

TEST(PcdGrid, ReadsAsciiAndBinary) {
  const TemporaryFolder folder;
  const auto ascii =
      value_of(read_grid_file(folder.write("a.pcd", header(kSize, "ascii") + kPoints)));
  EXPECT_EQ(ascii.points.width(), 3);
  EXPECT_EQ(ascii.points(1, 1), Eigen::Vector3d(1, 1, 2));
  EXPECT_FALSE(ascii.points(2, 0).allFinite());
  EXPECT_EQ(ascii.normals(0, 0), Eigen::Vector3f(0, 0, -1));
  const auto binary =
      value_of(read_grid_file(folder.write("b.pcd", header(kSize, "binary") + binary_points())));
  EXPECT_EQ(binary.points(0, 1), Eigen::Vector3d(18, 19, 20));
}

TEST(PcdGrid, LinesMayEndInReturns) {
  const TemporaryFolder folder;
  for (const std::string end : {"\r\n", "\r"}) {
    const auto ended = [&](const std::string& text) {
      std::string changed;
      for (const char c : text) changed += c == '\n' ? end : std::string(1, c);
      return changed;
    };
    const auto ascii =
        value_of(read_grid_file(folder.write("a.pcd", ended(header(kSize, "ascii") + kPoints))));
    EXPECT_EQ(ascii.points(1, 1), Eigen::Vector3d(1, 1, 2));
    EXPECT_FALSE(ascii.points(2, 0).allFinite());
    EXPECT_EQ(ascii.points(2, 1), Eigen::Vector3d(2, 1, 3));
    // The first byte of the data is a line feed: it is no part of the line before.
    const float first = 5.2f;
    std::string points = binary_points();
    std::memcpy(points.data(), &first, 4);
    points[0] = '\n';
    float expected = 0.0f;
    std::memcpy(&expected, points.data(), 4);
    const auto binary =
        value_of(read_grid_file(folder.write("b.pcd", ended(header(kSize, "binary")) + points)));
    EXPECT_EQ(binary.points(0, 0).x(), static_cast<double>(expected));
    EXPECT_EQ(binary.points(0, 1), Eigen::Vector3d(18, 19, 20));
  }
}

TEST(PcdGrid, SeveralPointsAtTheOriginAreMissingSamples) {
  const TemporaryFolder folder;
  const std::string none = "0 0 0 0 0 0\n", point = "0 1 2 0 0 -1\n";
  const auto read = [&](const std::string& points) {
    return value_of(read_grid_file(folder.write("a.pcd", header(kSize, "ascii") + points)));
  };
  const auto grid = read(none + point + none + point + point + none);
  EXPECT_FALSE(grid.points(0, 0).allFinite());
  EXPECT_FALSE(grid.points(2, 1).allFinite());
  EXPECT_EQ(grid.points(1, 0), Eigen::Vector3d(0, 1, 2));
  EXPECT_THAT(grid.notes, ::testing::ElementsAre(::testing::HasSubstr("3 points at the origin")));
  const auto one = read(none + point + point + point + point + point);
  EXPECT_TRUE(one.points(0, 0).allFinite());
  EXPECT_THAT(one.notes, ::testing::IsEmpty());
}

TEST(PcdGrid, PointsAtAnInvalidDepthAreMissingSamples) {
  const TemporaryFolder folder;
  const std::string far = "1 0 9.999 0 0 -1\n", point = "0 1 2 0 0 -1\n";
  const auto grid = value_of(read_grid_file(
      folder.write("a.pcd", header(kSize, "ascii") + far + point + point + far + point + point)));
  EXPECT_FALSE(grid.points(0, 0).allFinite());
  EXPECT_FALSE(grid.points(0, 1).allFinite());
  EXPECT_TRUE(grid.points(1, 1).allFinite());
  EXPECT_THAT(grid.notes,
              ::testing::ElementsAre(::testing::HasSubstr("2 points at the depth 9.999")));
}

// As LZF keeps what it cannot shorten: up to 32 bytes behind their number less one.
std::string compressed(const std::string& bytes) {
  std::string packed;
  for (std::size_t at = 0; at < bytes.size(); at += 32) {
    const std::string run = bytes.substr(at, 32);
    packed += static_cast<char>(run.size() - 1) + run;
  }
  const std::uint32_t sizes[] = {static_cast<std::uint32_t>(packed.size()),
                                 static_cast<std::uint32_t>(bytes.size())};
  return std::string(reinterpret_cast<const char*>(sizes), sizeof sizes) + packed;
}

// All values of a field, then those of the next.
std::string field_by_field(const std::string& points, const std::vector<std::size_t>& sizes) {
  std::size_t step = 0;
  for (const std::size_t size : sizes) step += size;
  std::string bytes;
  std::size_t offset = 0;
  for (const std::size_t size : sizes) {
    for (std::size_t at = offset; at < points.size(); at += step) bytes += points.substr(at, size);
    offset += size;
  }
  return bytes;
}

TEST(PcdGrid, ReadsCompressedPoints) {
  const TemporaryFolder folder;
  const auto binary =
      value_of(read_grid_file(folder.write("b.pcd", header(kSize, "binary") + binary_points())));
  const std::string bytes = field_by_field(binary_points(), std::vector<std::size_t>(6, 4));
  const auto packed = value_of(read_grid_file(
      folder.write("c.pcd", header(kSize, "binary_compressed") + compressed(bytes))));
  for (std::size_t i = 0; i < binary.points.size(); ++i) {
    EXPECT_EQ(binary.points[i], packed.points[i]);
    EXPECT_EQ(binary.normals[i], packed.normals[i]);
  }
}

// Doubles behind three bytes of something else, and colours behind them.
TEST(PcdGrid, ReadsCompressedFieldsOfSeveralSizes) {
  const TemporaryFolder folder;
  std::string points;
  for (std::uint32_t i = 0; i < 4; ++i) {
    const double xyz[] = {0.1 * (i % 2), 0.1 * (i / 2), 1.0 + i};
    const std::uint32_t colour = 0x0a141e + i;
    points += std::string(3, '?') + std::string(reinterpret_cast<const char*>(xyz), 24) +
              std::string(reinterpret_cast<const char*>(&colour), 4);
  }
  const std::string fields =
      "VERSION 0.7\nFIELDS label x y z rgb\nSIZE 1 8 8 8 4\nTYPE U F F F U\nCOUNT 3 1 1 1 1\n"
      "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA binary_compressed\n";
  const auto grid = value_of(read_grid_file(
      folder.write("c.pcd", fields + compressed(field_by_field(points, {3, 8, 8, 8, 4})))));
  EXPECT_EQ(grid.points(1, 1), Eigen::Vector3d(0.1, 0.1, 4.0));
  EXPECT_EQ(grid.colours(1, 1), (Colour{10, 20, 33}));
}

class PcdColoursOfType : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Types, PcdColoursOfType, ::testing::Values("F", "U"),
                         testing::PrintedName());

TEST_P(PcdColoursOfType, UnpacksColours) {
  const TemporaryFolder folder;
  std::string bytes;
  for (std::uint32_t i = 0; i < 4; ++i) {
    const float xyz[] = {static_cast<float>(i % 2), static_cast<float>(i / 2), 1.0f};
    const std::uint32_t packed = 0x0a141e + i;
    bytes.append(reinterpret_cast<const char*>(xyz), 12);
    bytes.append(reinterpret_cast<const char*>(&packed), 4);
  }
  const auto grid = value_of(read_grid_file(folder.write(
      "a.pcd", "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F " +
                   GetParam() +
                   "\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA "
                   "binary\n" +
                   bytes)));
  EXPECT_EQ(grid.colours(0, 0), (Colour{10, 20, 30}));
  EXPECT_EQ(grid.colours(1, 1), (Colour{10, 20, 33}));
}

TEST(PcdGrid, ReadsTheViewpoint) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& viewpoint) {
    std::string content = header(kSize, "ascii") + kPoints;
    content.replace(content.find("0 0 0 1 0 0 0"), 13, viewpoint);
    return read_grid_file(folder.write("a.pcd", content));
  };
  EXPECT_FALSE(read("0 0 0 1 0 0 0")->world_from_view.has_value());
  const auto turned = value_of(read("1 2 3 0 0 0 1"));
  ASSERT_TRUE(turned.world_from_view.has_value());
  EXPECT_TRUE(
      (*turned.world_from_view * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0, 2, 3)));
  EXPECT_THAT(read("0 0 0 0 0 0 0"), HasError("a.pcd: VIEWPOINT"));
}

TEST(PcdGrid, RefusesWhatIsNoGrid) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& content) {
    return read_grid_file(folder.write("a.pcd", content));
  };
  EXPECT_THAT(read(header("WIDTH 6\nHEIGHT 1\n", "ascii") + kPoints), HasError("not organized"));
  EXPECT_THAT(read(header(kSize, "binary") + binary_points().substr(1)), HasError("truncated"));
  EXPECT_THAT(read(header("WIDTH 6\nHEIGHT 1\n", "binary") + binary_points().substr(1)),
              HasError("truncated"));
  EXPECT_THAT(read(""), HasError("a.pcd"));
  EXPECT_THAT(read_grid_file(folder / "missing.pcd"), HasError());
}

std::string large_header(const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\n"
         "WIDTH 65536\nHEIGHT 65536\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4294967296\nDATA " +
         data + "\n";
}

TEST(PcdGrid, AHeaderAloneTakesNoMemory) {
  const TemporaryFolder folder;
  const LimitedMemory limit(std::size_t{1} << 30);
  for (const char* data : {"ascii", "binary", "binary_compressed"}) {
    EXPECT_THAT(read_grid_file(folder.write("a.pcd", large_header(data) + "0 0 1\n")),
                HasError("a.pcd: truncated PCD: 4294967296 points"))
        << data;
  }
}

TEST(PcdGrid, DataThatBeginWithAKeywordAreData) {
  const TemporaryFolder folder;
  std::string bytes = binary_points();
  const std::string keyword = "COLUMNS x\nPOINTS 4294967295\n";
  bytes.replace(0, keyword.size(), keyword);
  const LimitedMemory limit(std::size_t{1} << 30);
  const auto grid =
      value_of(read_grid_file(folder.write("a.pcd", header(kSize, "binary") + bytes)));
  EXPECT_EQ(grid.points(0, 1), Eigen::Vector3d(18, 19, 20));
}

// PCL takes fields without a TYPE for floats, whatever their size.
TEST(PcdGrid, RefusesFieldsOfAnotherSizeThanTheirType) {
  const TemporaryFolder folder;
  std::string text = header(kSize, "binary");
  text.erase(text.find("TYPE"), std::string("TYPE F F F F F F\n").size());
  text.replace(text.find("SIZE 4 4 4 4 4 4"), 16, "SIZE 4 4 4 4 1 1");
  EXPECT_THAT(read_grid_file(folder.write("a.pcd", text + binary_points())),
              HasError("damaged PCD header"));
}

TEST(PcdGrid, HoldsCompressedSizesAgainstTheFile) {
  const TemporaryFolder folder;
  const auto error = [&](std::uint32_t compressed, std::uint32_t whole) {
    std::string bytes(8, '\0');
    std::memcpy(bytes.data(), &compressed, 4);
    std::memcpy(bytes.data() + 4, &whole, 4);
    return read_grid_file(
        folder.write("a.pcd", header(kSize, "binary_compressed") + bytes + std::string(40, 'x')));
  };
  const LimitedMemory limit(std::size_t{1} << 30);
  EXPECT_THAT(error(41, 144), HasError("41 compressed bytes promised, 40 left"));
  EXPECT_THAT(error(40, 4000000000u), HasError("4000000000 bytes for 6 points of 24"));
  EXPECT_THAT(error(0, 144), HasError("damaged or truncated PCD"));
}

TEST(PcdGrid, NamesTheLineOfABadHeader) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& size) {
    return read_grid_file(folder.write("a.pcd", header(size, "ascii") + kPoints));
  };
  EXPECT_THAT(error("WIDTH 3\nHEIGHT two\n"), HasError("line 8 of the PCD header: 'two'"));
  EXPECT_THAT(error("WIDTH 3\nWIDTH 3\nHEIGHT 2\n"), HasError("a second line WIDTH"));
  EXPECT_THAT(error("WIDTH 3\nHEIGHT 3\n"), HasError("bad size"));
}

// Of programs that know POINTS alone.
TEST(PcdGrid, PointsTellTheSizeWhereItIsZero) {
  const TemporaryFolder folder;
  for (const bool ascii : {true, false}) {
    const auto path =
        folder.write("a.pcd", header("WIDTH 0\nHEIGHT 0\n", ascii ? "ascii" : "binary") +
                                  (ascii ? std::string(kPoints) : binary_points()));
    const auto cloud = value_of(read_pcd_points(path));
    EXPECT_EQ(cloud.points.width(), 6);
    EXPECT_EQ(cloud.points.height(), 1);
    EXPECT_THAT(read_pcd_grid(path), HasError("not organized"));
  }
  EXPECT_THAT(read_pcd_points(folder.write("a.pcd", header("WIDTH 0\nHEIGHT 2\n", "ascii"))),
              HasError("bad size"));
}

TEST(PcdGrid, DamagedFilesNeverCrash) {
  const TemporaryFolder folder;
  std::mt19937 random(3);
  for (const bool ascii : {true, false}) {
    const std::string content =
        ascii ? header(kSize, "ascii") + kPoints : header(kSize, "binary") + binary_points();
    for (std::size_t size = 0; size < content.size(); ++size)
      (void)read_grid_file(folder.write("a.pcd", content.substr(0, size)));
    for (int k = 0; k < 1500; ++k) {
      std::string changed = content;
      changed[random() % changed.size()] =
          static_cast<char>(random() % 3 ? random() % 256 : '0' + random() % 10);
      (void)read_grid_file(folder.write("a.pcd", changed));
    }
  }
}

}  // namespace
}  // namespace relief
