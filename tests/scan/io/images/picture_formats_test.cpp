// Radiance and WebP; what all pictures have in common.
#include <array>
#include <string>
#include <tuple>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/images/image_io.h"
#include "tests/scan/io/images/picture_files.h"
#include "tests/support/limited_memory.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::bmp;
using testing::bytes_of;
using testing::expect_errors_when_damaged;
using testing::expect_samples;
using testing::hdr;
using testing::kBmpRows;
using testing::kTwoHdrPixels;
using testing::LimitedMemory;
using testing::TemporaryFolder;
using testing::tga;

TEST(PictureFormats, HdrIsReadFlatInEveryOrientation) {
  const std::vector<float> first{1.0f, 0.5f, 0.25f}, black{0, 0, 0};
  const auto both = [](std::vector<float> a, const std::vector<float>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  };
  for (const auto& [size, width, height, turned] :
       {std::tuple{"-Y 1 +X 2", 2, 1, false}, std::tuple{"-Y 1 -X 2", 2, 1, true},
        std::tuple{"-Y 2 +X 1", 1, 2, false}, std::tuple{"+Y 2 +X 1", 1, 2, true},
        std::tuple{"+X 1 -Y 2", 1, 2, false}, std::tuple{"+X 1 +Y 2", 1, 2, true},
        std::tuple{"+X 2 +Y 1", 2, 1, false}, std::tuple{"-X 2 +Y 1", 2, 1, true}}) {
    SCOPED_TRACE(size);
    expect_samples(decode_hdr(hdr(size, kTwoHdrPixels), "a"), width, height, 3,
                   turned ? both(black, first) : both(first, black), 0.0);
  }
}

TEST(PictureFormats, HdrRunsAreUnpacked) {
  // A line of 8: red a run, green as it is, blue and the exponent runs.
  const std::string line("\2\2\0\10\x88\x80\10\0\1\2\3\4\5\6\7\x88\0\x88\x81", 19);
  std::vector<float> expected;
  for (int u = 0; u < 8; ++u) {
    expected.push_back(1.0f);
    expected.push_back(static_cast<float>(u) / 128.0f);
    expected.push_back(0.0f);
  }
  const std::string file = hdr("-Y 1 +X 8", line);
  expect_samples(decode_hdr(file, "a"), 8, 1, 3, expected, 0.0);
  expect_errors_when_damaged(file, decode_hdr);
  expect_errors_when_damaged(hdr("-Y 1 +X 2", kTwoHdrPixels), decode_hdr);
}

TEST(PictureFormats, DamagedHdrRunsAreErrors) {
  const auto decode = [](const std::string& line) {
    return decode_hdr(hdr("-Y 1 +X 8", line + std::string(64, '\1')), "a");
  };
  EXPECT_THAT(decode(std::string("\2\2\0\11", 4)), HasError("another length"));
  EXPECT_THAT(decode(std::string("\2\2\0\10\x89\x80", 6)), HasError("beyond its line"));
  EXPECT_THAT(decode(std::string("\2\2\0\10\0\x80", 6)), HasError("beyond its line"));
  EXPECT_THAT(decode(std::string("\x80\x80\x80\x80\1\1\1\7", 8)), HasError("first version"));
}

TEST(PictureFormats, AnHdrThatIsNoneIsRefused) {
  const LimitedMemory limit(std::size_t{1} << 28);
  EXPECT_THAT(decode_hdr(hdr("-Y 65535 +X 65535", "abcd"), "a"), HasError());
  EXPECT_THAT(decode_hdr(hdr("-Y 8000 +X 8000", "abcd"), "a"), HasError("far more than"));
  EXPECT_THAT(decode_hdr("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd", "a"),
              HasError("save it as 32-bit_rle_rgbe"));
}

// 4x3 pixels whose sample of channel c is 20 i + 5 c, by libwebp.
constexpr std::array<unsigned char, 60> kLosslessWebp{
    0x52, 0x49, 0x46, 0x46, 0x34, 0x00, 0x00, 0x00, 0x57, 0x45, 0x42, 0x50, 0x56, 0x50, 0x38,
    0x4c, 0x27, 0x00, 0x00, 0x00, 0x2f, 0x03, 0x80, 0x00, 0x00, 0x5f, 0x20, 0x16, 0x4c, 0xae,
    0x19, 0xe4, 0x8f, 0x1b, 0xc3, 0x50, 0x5c, 0x81, 0x62, 0xfe, 0x13, 0xdb, 0x81, 0x20, 0x80,
    0x44, 0x21, 0x96, 0x58, 0x66, 0x99, 0x65, 0x96, 0x49, 0x23, 0xfa, 0x1f, 0x98, 0xee, 0x00};
// The same with half of the pixels half transparent.
constexpr std::array<unsigned char, 84> kTransparentWebp{
    0x52, 0x49, 0x46, 0x46, 0x4c, 0x00, 0x00, 0x00, 0x57, 0x45, 0x42, 0x50, 0x56, 0x50,
    0x38, 0x4c, 0x3f, 0x00, 0x00, 0x00, 0x2f, 0x03, 0x80, 0x00, 0x10, 0x5f, 0xa0, 0xa6,
    0x6d, 0x03, 0x06, 0x47, 0xff, 0xc9, 0x9f, 0x62, 0x48, 0x28, 0x64, 0x1b, 0x01, 0x0e,
    0x49, 0x0c, 0x61, 0xf7, 0xa8, 0x69, 0xdb, 0x80, 0x0d, 0x31, 0xc9, 0x95, 0x0e, 0x01,
    0x41, 0xd1, 0x73, 0xa6, 0xa7, 0xe0, 0xff, 0xb0, 0xf6, 0x1f, 0x20, 0x0b, 0x30, 0x8d,
    0x7e, 0x53, 0x98, 0x42, 0x0a, 0x29, 0xa4, 0x50, 0x44, 0xff, 0x03, 0xd3, 0x1d, 0x00};
// 16x16 pixels of 100, lossy.
constexpr std::array<unsigned char, 44> kLossyWebp{
    0x52, 0x49, 0x46, 0x46, 0x24, 0x00, 0x00, 0x00, 0x57, 0x45, 0x42, 0x50, 0x56, 0x50, 0x38,
    0x20, 0x18, 0x00, 0x00, 0x00, 0x30, 0x01, 0x00, 0x9d, 0x01, 0x2a, 0x10, 0x00, 0x10, 0x00,
    0x02, 0xc0, 0x4c, 0x25, 0xa4, 0x00, 0x03, 0x70, 0x00, 0xfe, 0xe7, 0x75, 0x00, 0x00};

template <std::size_t N>
std::string file_of(const std::array<unsigned char, N>& bytes) {
  return std::string(bytes.begin(), bytes.end());
}

TEST(PictureFormats, WebpIsReadAndItsAlphaDropped) {
  std::vector<float> expected;
  for (int i = 0; i < 12; ++i)
    for (int c = 0; c < 3; ++c) expected.push_back(static_cast<float>(20 * i + 5 * c));
  expect_samples(decode_webp(file_of(kLosslessWebp), "a"), 4, 3, 3, expected);
  expect_samples(decode_webp(file_of(kTransparentWebp), "a"), 4, 3, 3, expected);
  const auto lossy = value_of(decode_webp(file_of(kLossyWebp), "a"));
  EXPECT_EQ(lossy.width, 16);
  for (const float sample : lossy.samples) EXPECT_NEAR(sample, 100.0f, 3.0f);
}

TEST(PictureFormats, DamagedWebpIsAnError) {
  expect_errors_when_damaged(file_of(kLosslessWebp), decode_webp);
  expect_errors_when_damaged(file_of(kTransparentWebp), decode_webp);
  expect_errors_when_damaged(file_of(kLossyWebp), decode_webp);
  std::string large = file_of(kLosslessWebp);
  large.replace(21, 4, bytes_of(std::uint32_t{0x0fffffff}));
  const LimitedMemory limit(std::size_t{1} << 28);
  EXPECT_THAT(decode_webp(large, "a"), HasError("16384x16384 pixels, far more than"));
}

TEST(PictureFormats, SizesAreReadWithoutPixels) {
  const TemporaryFolder folder;
  const auto size = [&](const char* name, const std::string& content) {
    return image_size(folder.write(name, content)).value_or(ImageSize{});
  };
  EXPECT_EQ(size("a.bmp", bmp(2, -2, 24, "", kBmpRows)), (ImageSize{2, 2}));
  EXPECT_EQ(size("a.tga", tga(3, 3, 2, 8, 0, "")), (ImageSize{3, 2}));
  EXPECT_EQ(size("a.hdr", hdr("+X 3 -Y 2", "")), (ImageSize{3, 2}));
  EXPECT_EQ(size("a.webp", file_of(kLosslessWebp)), (ImageSize{4, 3}));
  EXPECT_EQ(size("b.webp", file_of(kTransparentWebp)), (ImageSize{4, 3}));
  EXPECT_EQ(size("c.webp", file_of(kLossyWebp)), (ImageSize{16, 16}));
}

TEST(PictureFormats, AreChosenByTheirEnding) {
  const TemporaryFolder folder;
  EXPECT_THAT(read_image(folder.write("a.BMP", bmp(2, 2, 24, "", kBmpRows))), IsOk());
  EXPECT_THAT(read_image(folder.write("a.tga", tga(3, 2, 1, 8, 0, "ab"))), IsOk());
  EXPECT_THAT(read_image(folder.write("a.hdr", hdr("-Y 1 +X 2", kTwoHdrPixels))), IsOk());
  EXPECT_THAT(read_image(folder.write("a.webp", file_of(kLosslessWebp))), IsOk());
}

}  // namespace
}  // namespace relief
