#include <array>
#include <cstring>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "scan/base/memory/memory_limit.h"
#include "scan/io/files/ply_file.h"
#include "scan/io/grids/grid_file.h"
#include "tests/support/limited_memory.h"
#include "tests/support/memory_limits.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::ElementsAre;
using testing::LimitedMemory;
using testing::TemporaryFolder;

auto parse(std::string_view content) { return parse_ply(content, "scan.ply"); }

template <typename T>
void append_big_endian(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  for (std::size_t i = sizeof(T); i > 0; --i) bytes += raw[i - 1];
}

TEST(Ply, ReadsEveryScalarTypeInAscii) {
  const auto ply = value_of(parse_ply(
      "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info num_cols 5\r\n"
      "element vertex 1\r\nproperty char a\r\nproperty uint8 b\r\nproperty short c\r\n"
      "property ushort d\r\nproperty int32 e\r\nproperty uint f\r\nproperty float32 g\r\n"
      "property double h\r\nend_header\r\n-128 255 -32768 65535 -2147483648 4294967295 +1.5 "
      "1e-300\r\n",
      "a.ply"));
  EXPECT_EQ(ply.object_info.at("num_cols"), "5");
  const auto& properties = ply.find("vertex")->properties;
  std::vector<double> values;
  for (const auto& property : properties) values.push_back(property.values.at(0));
  EXPECT_THAT(values,
              ElementsAre(-128, 255, -32768, 65535, -2147483648.0, 4294967295.0, 1.5, 1e-300));
}

TEST(Ply, LinesMayEndInReturnsAlone) {
  const auto ply = value_of(
      parse("ply\rformat ascii 1.0\relement vertex 2\rproperty float x\rend_header\r1.5\r2.5\r"));
  EXPECT_THAT(ply.find("vertex")->properties.at(0).values, ElementsAre(1.5, 2.5));
}

// A mesh of `rows` x `columns` vertices as a binary PLY file.
std::string plane_of(std::uint32_t rows, std::uint32_t columns) {
  std::string bytes = "ply\nformat binary_big_endian 1.0\nelement vertex " +
                      std::to_string(rows * columns) +
                      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                      std::to_string(2 * (rows - 1) * (columns - 1)) +
                      "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (std::uint32_t i = 0; i < rows * columns; ++i)
    for (const auto value :
         {static_cast<float>(i % columns), static_cast<float>(i / columns), 0.0f})
      append_big_endian(bytes, value);
  for (std::uint32_t v = 0; v + 1 < rows; ++v) {
    for (std::uint32_t u = 0; u + 1 < columns; ++u) {
      const std::uint32_t a = v * columns + u, b = a + columns;
      for (const auto& face : {std::array{a, a + 1, b}, std::array{b, a + 1, b + 1}}) {
        bytes += '\x03';
        for (const std::uint32_t corner : face) append_big_endian(bytes, corner);
      }
    }
  }
  return bytes;
}

TEST(Ply, ColumnsOfLargeMeshesKeepToAMemoryLimit) {
  const TemporaryFolder folder;
  std::ofstream(folder / "plane.ply", std::ios::binary) << plane_of(700, 500);
  const Context context{.memory = 128 * testing::kMebibyte, .temporary_folder = folder.path()};
  ASSERT_TRUE(run_until_stopped(context, [&] {
    const std::size_t before = resident_beyond_files();
    const auto ply = read_ply(folder / "plane.ply");
    EXPECT_LT(resident_beyond_files(), before + 18 * testing::kMebibyte) << "of 31 MB";
    ASSERT_THAT(ply, IsOk());
    const PlyElement* face = ply->find("face");
    ASSERT_EQ(face->count, 697'602u);
    EXPECT_EQ(face->properties[0].values.back(), 349'999.0);
  }));
}

TEST(Ply, ReadsBigEndianListsAndScalars) {
  std::string content =
      "ply\nformat binary_big_endian 1.0\nelement face 2\nproperty uchar red\n"
      "property list uchar int vertex_indices\nproperty double area\nend_header\n";
  content += '\x07';
  content += '\x02';
  append_big_endian(content, std::int32_t{-5});
  append_big_endian(content, std::int32_t{70000});
  append_big_endian(content, 2.5);
  content += '\x08';
  content += '\0';
  append_big_endian(content, -0.125);
  const auto ply = value_of(parse_ply(content, "a.ply"));
  const PlyElement* face = ply.find("face");
  EXPECT_THAT(face->find("red")->values, ElementsAre(7, 8));
  EXPECT_THAT(face->find("vertex_indices")->values, ElementsAre(-5, 70000));
  EXPECT_THAT(face->find("vertex_indices")->starts, ElementsAre(0, 2, 2));
  EXPECT_THAT(face->find("area")->values, ElementsAre(2.5, -0.125));
}

const std::string kVertices =
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nend_header\n";

TEST(Ply, NamesTheLineOfTextWhereANumberBelongs) {
  EXPECT_THAT(parse(kVertices + "1 2\n3 four\n"), HasError("scan.ply: line 8", "'four'"));
  EXPECT_THAT(parse(kVertices + "1.25 2.5\n3.75\n"), HasError("line 8"));
  EXPECT_THAT(parse(kVertices + "1 2 3\n3 4\n"), HasError("line 7"));
  EXPECT_THAT(parse(kVertices + "1.25 2.5\n"), HasError("vertex 1 of 2"));
}

TEST(Ply, NamesElementAndByteOfATruncatedBinaryFile) {
  EXPECT_THAT(parse("ply\nformat binary_little_endian 1.0\nelement face 1\n"
                    "property list int float values\nend_header\n\x05" +
                    std::string(3, '\0') + "abcd"),
              HasError("element face 0, byte ", "truncated"));
}

TEST(Ply, RefusesCountsThatTheFileCannotHold) {
  const auto with_count = [](const std::string& format, const std::string& count) {
    return "ply\nformat " + format + " 1.0\nelement vertex " + count +
           "\nproperty double x\nend_header\n1\n2\n";
  };
  for (const std::string count : {"1000000000000", "18446744073709551615", "3"}) {
    EXPECT_THAT(parse(with_count("ascii", count)), HasError("truncated"));
    EXPECT_THAT(parse(with_count("binary_little_endian", count)), HasError("truncated"));
  }
  EXPECT_THAT(parse(with_count("ascii", "99999999999999999999999")), HasError("line 3"));
  EXPECT_THAT(parse(with_count("ascii", "-1")), HasError("line 3"));
}

TEST(Ply, SkipsHeaderLinesOfOneUnknownWord) {
  const auto ply = value_of(parse_ply(
      "ply\nformat ascii 1.0\nbye\nelement vertex 1\nbye\nproperty float x\nend_header\n7\n",
      "bye.ply"));
  EXPECT_THAT(ply.find("vertex")->properties.at(0).values, ElementsAre(7));
}

TEST(Ply, NamesTheLineOfABadHeader) {
  EXPECT_THAT(parse("solid\n"), HasError("not a PLY"));
  EXPECT_THAT(parse("ply\nformat utf8 1.0\n"), HasError("line 2"));
  EXPECT_THAT(parse("ply\nformat ascii 1.0\nproperty float x\n"), HasError("line 3"));
  EXPECT_THAT(parse("ply\nformat ascii 1.0\nelement v 1\nproperty long x\n"), HasError("'long'"));
  EXPECT_THAT(parse("ply\nformat ascii 1.0\nelement v 1\nproperty list float int x\n"),
              HasError("counted"));
  EXPECT_THAT(parse("ply\nformat ascii 1.0\n"), HasError("inside its header"));
  EXPECT_THAT(parse("ply\nformat ascii 1.0\nproprety float x\n"), HasError("line 3", "'proprety'"));
}

std::string grid(const std::string& size, const std::string& vertices, const std::string& places) {
  const auto lines = [](const std::string& text) {
    return std::to_string(std::count(text.begin(), text.end(), '\n'));
  };
  return "ply\nformat ascii 1.0\n" + size + "element vertex " + lines(vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\nproperty float confidence\n"
         "element range_grid " +
         lines(places) + "\nproperty list uchar int vertex_indices\nend_header\n" + vertices +
         places;
}
const std::string kSize = "obj_info num_cols 3\nobj_info num_rows 1\n";

TEST(PlyGrid, PlacesVerticesAndLeavesGaps) {
  const TemporaryFolder folder;
  const auto read = value_of(
      read_grid_file(folder.write("a.ply", grid(kSize, "1 2 3 0.5\n4 5 6 1\n", "1 1\n0\n1 0\n"))));
  EXPECT_EQ(read.points(0, 0), Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(read.points(1, 0).allFinite());
  EXPECT_EQ(read.points(2, 0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(read.confidence(2, 0), 0.5f);
}

TEST(PlyGrid, RefusesPlacesThatTakeNoRoomInTheFile) {
  const TemporaryFolder folder;
  const auto path =
      folder.write("a.ply",
                   "ply\nformat ascii 1.0\nobj_info num_cols 65536\nobj_info num_rows 65536\n"
                   "element vertex 1\nproperty char x\nproperty char y\nproperty char z\n"
                   "element range_grid 4294967296\nend_header\n1 2 3\n");
  const LimitedMemory limit(std::size_t{1} << 30);
  EXPECT_THAT(read_grid_file(path), HasError("a.ply", "element range_grid without any property"));
}

TEST(PlyGrid, PointsThatAreNotFiniteAreNoSamples) {
  const TemporaryFolder folder;
  const auto read = value_of(read_grid_file(
      folder.write("a.ply", grid(kSize, "nan 2 3 1\n4 inf 6 1\n7 8 9 1\n", "1 0\n1 1\n1 2\n"))));
  EXPECT_FALSE(read.points(0, 0).allFinite());
  EXPECT_FALSE(read.points(1, 0).allFinite());
  EXPECT_TRUE(read.points(2, 0).allFinite());
}

TEST(PlyGrid, ErrorsSayWhatDoesNotFit) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& content) {
    return read_grid_file(folder.write("a.ply", content));
  };
  const std::string vertex = "1 2 3 1\n";
  EXPECT_THAT(read(grid(kSize, vertex, "1 0\n0\n1 1\n")), HasError("vertex index 1"));
  EXPECT_THAT(read(grid(kSize, vertex, "1 0\n0\n1 -1\n")), HasError("range_grid 2"));
  EXPECT_THAT(read(grid(kSize, vertex, "1 0\n0\n")), HasError("has 2 entries"));
  EXPECT_THAT(read(grid(kSize, vertex, "2 0 0\n0\n0\n")), HasError("2 vertices at one place"));
  EXPECT_THAT(read(grid("", vertex, "1 0\n0\n0\n")), HasError("num_cols"));
  EXPECT_THAT(read(grid("obj_info num_cols 3\nobj_info num_rows -1\n", vertex, "0\n")),
              HasError("num_rows is '-1'"));
  EXPECT_THAT(read("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n"),
              HasError("no scan grid"));
}

TEST(PlyGrid, ColoursAreWholeNumbersUpTo255) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& colour) {
    return read_grid_file(folder.write(
        "a.ply", "ply\nformat ascii 1.0\n" + kSize +
                     "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                     "property float red\nproperty float green\nproperty float blue\nend_header\n"
                     "0 0 1 10 20 255\n1 0 1 0 0 0\n2 0 1 " +
                     colour + "\n"));
  };
  const auto grid = value_of(read("1 2 3"));
  EXPECT_EQ(grid.colours(0, 0), (Colour{10, 20, 255}));
  EXPECT_EQ(grid.colours(2, 0), (Colour{1, 2, 3}));
  for (const char* wrong : {"256 0 0", "0 -1 0", "0 0 0.5", "nan 0 0"}) {
    EXPECT_THAT(read(wrong), HasError("vertex 2: red, green and blue")) << wrong;
  }
}

TEST(PlyGrid, OneVertexPerPlaceNeedsNoRangeGrid) {
  const TemporaryFolder folder;
  const auto read = value_of(read_grid_file(folder.write(
      "a.ply", "ply\nformat ascii 1.0\n" + kSize +
                   "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                   "end_header\n1 2 3\nnan nan nan\n4 5 6\n")));
  EXPECT_EQ(read.points(2, 0), Eigen::Vector3d(4, 5, 6));
}

}  // namespace
}  // namespace relief
