// NumPy arrays and files of bare floats as images.
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include <Eigen/Core>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/files/binary_writer.h"
#include "scan/io/images/codecs/floats/raw_floats.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/image_size.h"
#include "scan/io/project/view_spec.h"
#include "tests/scan/io/small_files.h"
#include "tests/support/limited_memory.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::LimitedMemory;
using testing::npy_array;
using testing::npy_file;
using testing::TemporaryFolder;

template <typename T>
std::string numbers_of(std::initializer_list<double> values, bool big = false) {
  std::string bytes;
  for (const double value : values) {
    std::string one;
    append_little_endian(one, static_cast<T>(value));
    if (big) std::reverse(one.begin(), one.end());
    bytes += one;
  }
  return bytes;
}

template <typename T>
void expect_type(const std::string& type, double max_value) {
  for (const bool big : {false, true}) {
    const auto read = value_of(decode_npy(
        npy_array((big ? ">" : "<") + type, "(2, 3)", numbers_of<T>({1, 2, 3, 4, 5, 100}, big)),
        "a.npy"));
    EXPECT_EQ(read.width, 3);
    EXPECT_EQ(read.height, 2);
    EXPECT_EQ(read.channels, 1);
    EXPECT_EQ(read.max_value, max_value) << type;
    EXPECT_EQ(read.samples, (std::vector<float>{1, 2, 3, 4, 5, 100})) << type;
  }
}

TEST(NpyImage, ReadsEveryTypeInBothOrdersOfBytes) {
  expect_type<std::uint8_t>("u1", 255.0);
  expect_type<std::uint16_t>("u2", 65535.0);
  expect_type<std::uint32_t>("u4", 0.0);
  expect_type<std::int8_t>("i1", 0.0);
  expect_type<std::int16_t>("i2", 0.0);
  expect_type<std::int32_t>("i4", 0.0);
  expect_type<std::uint64_t>("u8", 0.0);
  expect_type<std::int64_t>("i8", 0.0);
  expect_type<Eigen::half>("f2", 0.0);
  expect_type<float>("f4", 0.0);
  expect_type<double>("f8", 0.0);
  const auto truth =
      value_of(decode_npy(npy_array("|b1", "(1, 2)", std::string("\1\0", 2)), "a.npy"));
  EXPECT_EQ(truth.samples, (std::vector<float>{1, 0}));
}

TEST(NpyImage, ReadsBothOrdersOfAxesAndChannelsBehind) {
  const std::string numbers = numbers_of<float>({1, 2, 3, 4, 5, 6});
  const auto samples = [&](const char* shape, bool columns_first) {
    return value_of(decode_npy(npy_array("<f4", shape, numbers, columns_first), "a.npy")).samples;
  };
  EXPECT_EQ(samples("(2, 3)", true), (std::vector<float>{1, 3, 5, 2, 4, 6}));
  EXPECT_EQ(samples("(3, 2, 1)", false), (std::vector<float>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(samples("(1, 2, 3)", false), (std::vector<float>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(samples("(1, 2, 3)", true), (std::vector<float>{1, 3, 5, 2, 4, 6}));
}

TEST(NpyImage, ReadsLeadingAxesOfLength1) {
  for (const char* shape : {"(1, 2, 4)", "(1, 1, 2, 4)", "( 1L ,2L,4L , )"})
    for (const bool columns_first : {false, true}) {
      const std::string file =
          npy_array("f4", shape, numbers_of<float>({1, 2, 3, 4, 5, 6, 7, 8}), columns_first);
      const auto read = value_of(decode_npy(file, "a.npy"));
      EXPECT_EQ(read.width, 4) << shape;
      EXPECT_EQ(read.height, 2) << shape;
      EXPECT_EQ(read.samples[1], columns_first ? 3.0f : 2.0f) << shape;
      const TemporaryFolder folder;
      const auto size = image_size(folder.write("a.npy", file));
      ASSERT_TRUE(size) << shape;
      EXPECT_EQ(size->width, 4) << shape;
    }
  const auto colours = value_of(
      decode_npy(npy_array("<f4", "(1, 2, 1, 3)", numbers_of<float>({1, 2, 3, 4, 5, 6})), "a"));
  EXPECT_EQ(colours.channels, 3);
  EXPECT_EQ(colours.height, 2);
  EXPECT_THAT(decode_npy(npy_array("<f4", "(2, 2, 4)", std::string(64, 'a')), "a.npy"),
              HasError("its shape is (2,2,4,)"));
}

TEST(NpyImage, KeepsWhatIsNoNumber) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto read = value_of(decode_npy(
      npy_array("<f8", "(1, 3)", numbers_of<double>({std::nan(""), infinity, 0.1})), "a.npy"));
  EXPECT_TRUE(std::isnan(read.samples[0]));
  EXPECT_EQ(read.samples[1], std::numeric_limits<float>::infinity());
  EXPECT_EQ(read.samples[2], 0.1f);
}

TEST(NpyImage, ReadsVersions1To3) {
  const std::string dictionary = "{'shape':(1,1),'fortran_order':False,'descr':'<f4'}";
  for (const int version : {1, 2, 3})
    EXPECT_THAT(decode_npy(npy_file(dictionary, "abcd", version), "a.npy"), IsOk()) << version;
  EXPECT_THAT(decode_npy(npy_file(dictionary, "abcd", 4), "a.npy"), HasError("version 4"));
}

TEST(NpyImage, NamesWhatIsWrong) {
  const auto decode = [](const char* type, const char* shape, std::size_t bytes) {
    return decode_npy(npy_array(type, shape, std::string(bytes, 'a')), "a.npy");
  };
  EXPECT_THAT(decode("<f4", "(3, 4, 5)", 240), HasError("its shape is (3,4,5,)", "numpy.moveaxis"));
  EXPECT_THAT(decode("<f4", "(6,)", 24), HasError("an image has (rows, columns)"));
  EXPECT_THAT(decode("<c8", "(1, 1)", 8), HasError("numbers of type '<c8'"));
  EXPECT_THAT(decode("<f16", "(1, 1)", 16), HasError("array.astype('f4')"));
  EXPECT_THAT(decode("<f4", "(2, 2)", 17), HasError("takes 16 bytes, 17 follow"));
  EXPECT_THAT(decode("<f4", "(2, 0)", 0), HasError("is empty"));
  EXPECT_THAT(decode_npy(npy_file("{'descr': [('x', '<f4')], ", ""), "a.npy"),
              HasError("byte 20: expected {'descr'"));
}

TEST(NpyImage, DamagedFilesAreErrors) {
  const std::string whole = npy_array("<f4", "(2, 3)", std::string(24, 'a'));
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THAT(decode_npy(whole.substr(0, size), "a.npy"), HasError("a.npy: ")) << size;
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const char byte : {'\0', '9', '(', '\'', '\xff'}) {
      std::string changed = whole;
      changed[at] = byte;
      (void)decode_npy(changed, "a.npy");
    }
  const LimitedMemory limit(std::size_t{1} << 28);
  EXPECT_THAT(decode_npy(npy_array("<f4", "(65535, 65535)", "abcd"), "a.npy"), HasError());
  EXPECT_THAT(decode_npy(npy_array("<f4", "(4294967296, 4294967297)", "abcd"), "a.npy"),
              HasError());
}

TEST(RawFloats, NeedTheirSize) {
  const TemporaryFolder folder;
  const auto path = folder.write("a.raw", numbers_of<float>({1, 2, 3, 4, 5, 6}));
  EXPECT_THAT(read_image(path), HasError("add \"size\": [WIDTH, HEIGHT]"));
  const auto grey = value_of(read_image(path, ImageSize{3, 2}));
  EXPECT_EQ(grey.samples, (std::vector<float>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(grey(0, 1), 4.0f);
  const auto colour = value_of(read_image(path, ImageSize{2, 1}));
  EXPECT_EQ(colour.channels, 3);
  for (const ImageSize size :
       {ImageSize{3, 1}, ImageSize{4, 2}, ImageSize{0, 2}, ImageSize{-3, -2}})
    EXPECT_THAT(read_image(path, size), HasError()) << size.width;
  EXPECT_THAT(read_image(path, ImageSize{3, 1}), HasError("this file has 24"));
}

TEST(RawFloats, OtherImagesAreHeldAgainstTheSize) {
  const TemporaryFolder folder;
  const auto path = folder.write("a.pgm", std::string("P5 2 1 255\nab", 13));
  EXPECT_THAT(read_image(path, ImageSize{2, 1}), IsOk());
  EXPECT_THAT(read_image(path, ImageSize{1, 2}),
              HasError("is 2x1 pixels, but its \"size\" is 1x2"));
}

std::string scan_json(const std::string& depth, const std::string& more = "") {
  return R"({"format":"relief-scan","version":1,"views":[{"name":"a","depth":{)" + depth +
         R"(},"camera":{"model":"pinhole","fx":9,"fy":9,"cx":3,"cy":2})" + more + "}]}";
}

TEST(RawFloats, HaveTheirSizeInScanJson) {
  const auto parsed = value_of(parse_scan_json(
      scan_json(R"("file":"a.f32","size":[6,4])", R"(,"mask":{"file":"m.png","size":[6,4]})"),
      "scan.json"));
  EXPECT_EQ(parsed.views[0].depth->size, (ImageSize{6, 4}));
  EXPECT_EQ(parsed.views[0].mask->size, (ImageSize{6, 4}));
  const auto parse = [](const char* depth) {
    return parse_scan_json(scan_json(depth), "scan.json");
  };
  EXPECT_THAT(parse(R"("file":"a.raw")"), HasError("views[0].depth.size: missing"));
  EXPECT_THAT(parse(R"("file":"a.raw","size":[6])"), HasError("expected 2 numbers"));
  EXPECT_THAT(parse(R"("file":"a.raw","size":[6,1.5])"), HasError("two whole numbers"));
  EXPECT_THAT(parse(R"("file":"a.raw","size":[0,4])"), HasError("two whole numbers"));
}

}  // namespace
}  // namespace relief
