// BMP and TGA.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/images/image_io.h"
#include "tests/scan/io/images/picture_files.h"
#include "tests/support/limited_memory.h"
#include "tests/support/result_matchers.h"

namespace relief {
namespace {

using testing::bmp;
using testing::bytes_of;
using testing::expect_errors_when_damaged;
using testing::expect_samples;
using testing::grey_palette;
using testing::kBmpRows;
using testing::LimitedMemory;
using testing::tga;

TEST(BitmapFormats, BmpIsReadFromTheBottomUpAndFromTheTopDown) {
  expect_samples(decode_bmp(bmp(2, 2, 24, "", kBmpRows), "a"), 2, 2, 3,
                 {9, 8, 7, 12, 11, 10, 3, 2, 1, 6, 5, 4});
  expect_samples(decode_bmp(bmp(2, -2, 24, "", kBmpRows), "a"), 2, 2, 3,
                 {3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10});
  const std::string alpha("\1\2\3\200\4\5\6\0", 8);
  expect_samples(decode_bmp(bmp(2, 1, 32, "", alpha), "a"), 2, 1, 3, {3, 2, 1, 6, 5, 4});
}

TEST(BitmapFormats, BmpPalettesAreResolvedAndGreyOnesStayGrey) {
  expect_samples(decode_bmp(bmp(3, 1, 8, grey_palette(), std::string("\3\0\1\0", 4)), "a"), 3, 1, 1,
                 {30, 0, 10});
  expect_samples(decode_bmp(bmp(3, 1, 4, grey_palette(), std::string("\x30\x10\0\0", 4)), "a"), 3,
                 1, 1, {30, 0, 10});
  const std::string colours("\1\2\3\0\4\5\6\0", 8);
  expect_samples(decode_bmp(bmp(2, 1, 1, colours, std::string("\x80\0\0\0", 4)), "a"), 2, 1, 3,
                 {6, 5, 4, 3, 2, 1});
}

TEST(BitmapFormats, BmpOf16BitsHasItsMasks) {
  const std::string pixel("\xff\x07\0\0", 4);
  expect_samples(decode_bmp(bmp(1, 1, 16, "", pixel), "a"), 1, 1, 3, {8, 255, 255});
  const std::string masks = bytes_of(0xf800u, 0x7e0u, 0x1fu, 0u);
  expect_samples(decode_bmp(bmp(1, 1, 16, masks, pixel, 3), "a"), 1, 1, 3, {0, 255, 255});
  const std::string turned = bytes_of(0xfu, 0x30u, 0x1fc0u, 0u);  // Of 4, 2 and 7 bits.
  expect_samples(decode_bmp(bmp(1, 1, 16, turned, std::string("\x53\x00\0\0", 4), 3), "a"), 1, 1, 3,
                 {51, 85, 2});
  for (const std::string& strange :
       {bytes_of(0xf500u, 0x7e0u, 0x1fu, 0u), bytes_of(0u, 0x7e0u, 0x1fu, 0u),
        bytes_of(0x1f0000u, 0x7e0u, 0x1fu, 0u)})
    EXPECT_THAT(decode_bmp(bmp(1, 1, 16, strange, pixel, 3), "a"), HasError("masks"));
}

TEST(BitmapFormats, BmpOf32BitsHasItsMasks) {
  const std::string masks = bytes_of(0xffu, 0xff00u, 0xff0000u, 0xff000000u);
  const std::string pixels("\1\2\3\4\5\6\7\10", 8);
  expect_samples(decode_bmp(bmp(2, 1, 32, masks, pixels, 3), "a"), 2, 1, 3, {1, 2, 3, 5, 6, 7});
  const std::string wide = bytes_of(0x3ffu, 0xffc00u, 0x3ff00000u, 0u);
  expect_samples(decode_bmp(bmp(1, 1, 32, wide, bytes_of(0x3ffu | 512u << 20), 3), "a"), 1, 1, 3,
                 {255, 0, 128});
  expect_errors_when_damaged(bmp(2, 1, 32, masks, pixels, 3), decode_bmp);
}

TEST(BitmapFormats, BmpRunsAreUnpackedAlsoWithGreyPalettes) {
  // Three of 1, one of 2; end of line; two as they are; end.
  const std::string runs("\3\1\1\2\0\0\0\4\3\2\1\0\0\1", 14);
  const std::vector<float> grey{30, 20, 10, 0, 10, 10, 10, 20};
  const std::string file = bmp(4, 2, 8, grey_palette(), runs, 1);
  expect_samples(decode_bmp(file, "a"), 4, 2, 1, grey);
  expect_errors_when_damaged(file, decode_bmp);
  EXPECT_THAT(decode_bmp(bmp(4, 2, 24, "", runs, 1), "a"), HasError());
}

TEST(BitmapFormats, BmpRunsOfFourBitsAreUnpacked) {
  // Three of 1, 2, 1; end of line; three as they are; end.
  const std::string runs("\3\x12\0\0\0\3\x32\x10\0\1", 10);
  const std::string file = bmp(3, 2, 4, grey_palette(), runs, 2);
  expect_samples(decode_bmp(file, "a"), 3, 2, 1, {30, 20, 10, 10, 20, 10});
  expect_errors_when_damaged(file, decode_bmp);
}

TEST(BitmapFormats, BmpRunsCoverEveryPixelOfTheirLines) {
  const auto decode = [](const std::string& runs) {
    return decode_bmp(bmp(4, 2, 8, grey_palette(), runs, 1), "a");
  };
  EXPECT_THAT(decode(std::string("\5\1\0\0\4\1\0\1", 8)), HasError("beyond its line"));
  EXPECT_THAT(decode(std::string("\4\1\4\1\0\1", 6)), HasError("beyond its line"));
  EXPECT_THAT(decode(std::string("\4\1\0\0\4\1\0\0\1\1\0\1", 12)), HasError("beyond its line"));
  EXPECT_THAT(decode(std::string("\3\1\0\0\4\1\0\1", 8)), HasError("leave pixels out"));
  EXPECT_THAT(decode(std::string("\4\1\0\1", 4)), HasError("leave pixels out"));
  EXPECT_THAT(decode(std::string("\0\2\4\1\0\1", 6)), HasError("leave pixels out"));
  EXPECT_THAT(decode(std::string("\4\1\0\0\4\4\0\1", 8)),
              HasError("pixel 0 has colour 4, which its palette does not have"));
}

TEST(BitmapFormats, DamagedBmpIsAnError) {
  expect_errors_when_damaged(bmp(2, 2, 24, "", kBmpRows), decode_bmp);
  const LimitedMemory limit(std::size_t{1} << 28);
  EXPECT_THAT(decode_bmp(bmp(65535, 65535, 24, "", kBmpRows), "a"),
              HasError("more than can be read"));
  EXPECT_THAT(decode_bmp(bmp(16000, 16000, 8, grey_palette(), "ab", 1), "a"),
              HasError("far more than a file of"));
}

TEST(BitmapFormats, TgaHasAnOrientation) {
  const std::string pixels("\1\2\3\4\5\6", 6);  // Two rows of three greys.
  expect_samples(decode_tga(tga(3, 3, 2, 8, 0, pixels), "a"), 3, 2, 1, {4, 5, 6, 1, 2, 3});
  expect_samples(decode_tga(tga(3, 3, 2, 8, 0x20, pixels), "a"), 3, 2, 1, {1, 2, 3, 4, 5, 6});
  expect_samples(decode_tga(tga(3, 3, 2, 8, 0x30, pixels), "a"), 3, 2, 1, {3, 2, 1, 6, 5, 4});
  expect_samples(decode_tga(tga(2, 2, 1, 24, 0x20, pixels), "a"), 2, 1, 3, {3, 2, 1, 6, 5, 4});
  expect_errors_when_damaged(tga(3, 3, 2, 8, 0x20, pixels), decode_tga);
}

TEST(BitmapFormats, TgaAlphaIsDroppedAndChangesNoColour) {
  const std::string pixels("\12\24\36\100\1\2\3\0", 8);
  expect_samples(decode_tga(tga(2, 2, 1, 32, 0x28, pixels), "a"), 2, 1, 3, {30, 20, 10, 3, 2, 1});
  expect_samples(decode_tga(tga(3, 4, 1, 16, 0x28, pixels), "a"), 4, 1, 1, {10, 30, 1, 3});
}

TEST(BitmapFormats, TgaOf16BitsHasFiveForAColour) {
  const std::string pixels = bytes_of(std::uint16_t{0x7c00 | 1 << 5}, std::uint16_t{0x8010});
  expect_samples(decode_tga(tga(2, 2, 1, 16, 0x21, pixels), "a"), 2, 1, 3, {255, 8, 0, 0, 0, 132});
}

TEST(BitmapFormats, TgaRunsAreUnpacked) {
  // Three of a colour, then two as they are.
  const std::string runs("\x82\1\2\3\1\4\5\6\7\10\11\x80\0\0\0", 15);
  const std::string file = tga(10, 3, 2, 24, 0x20, runs);
  expect_samples(decode_tga(file, "a"), 3, 2, 3,
                 {3, 2, 1, 3, 2, 1, 3, 2, 1, 6, 5, 4, 9, 8, 7, 0, 0, 0});
  expect_errors_when_damaged(file, decode_tga);
  EXPECT_THAT(decode_tga(tga(11, 2, 2, 8, 0x20, "\x84z"), "a"),
              HasError("go on after its last pixel"));
}

TEST(BitmapFormats, TgaPalettesAreResolvedWithinTheirBounds) {
  const std::string palette("\1\2\3\4\5\6", 6);
  expect_samples(decode_tga(tga(1, 2, 1, 8, 0x20, std::string("\1\0", 2), palette, 2, 24), "a"), 2,
                 1, 3, {6, 5, 4, 3, 2, 1});
  expect_samples(decode_tga(tga(9, 2, 1, 8, 0x20, std::string("\x81\1", 2), palette, 2, 24), "a"),
                 2, 1, 3, {6, 5, 4, 6, 5, 4});
  EXPECT_THAT(decode_tga(tga(1, 2, 1, 8, 0x20, std::string("\1\2", 2), palette, 2, 24), "a"),
              HasError("pixel 1 has colour 2, which its palette does not have"));
  expect_errors_when_damaged(tga(9, 2, 1, 8, 0x20, std::string("\x81\1", 2), palette, 2, 24),
                             decode_tga);
}

TEST(BitmapFormats, ALyingTgaIsRefusedBeforeMemoryIsTaken) {
  const LimitedMemory limit(std::size_t{1} << 28);
  EXPECT_THAT(decode_tga(tga(2, 65535, 65535, 24, 0, "abc"), "a"), HasError());
  EXPECT_THAT(decode_tga(tga(10, 8000, 8000, 32, 0, "abc"), "a"),
              HasError("far more than a file of 24 bytes"));
}

}  // namespace
}  // namespace relief
