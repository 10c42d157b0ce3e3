#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/files/binary_writer.h"
#include "scan/io/images/image_io.h"
#include "tests/support/limited_memory.h"
#include "tests/support/result_matchers.h"

// Pictures made byte by byte, and what must come of them.
namespace relief::testing {

using Decode = Result<Image> (*)(std::string_view content, const std::filesystem::path& path);

inline void expect_samples(const Result<Image>& read, int width, int height, int channels,
                           const std::vector<float>& samples, double max_value = 255.0) {
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(read->width, width);
  EXPECT_EQ(read->height, height);
  EXPECT_EQ(read->channels, channels);
  EXPECT_EQ(read->max_value, max_value);
  EXPECT_EQ(read->samples, samples);
}

// Every prefix is an error that names the file; damaged bytes give an error or a value.
inline void expect_errors_when_damaged(const std::string& whole, Decode decode) {
  ASSERT_THAT(decode(whole, "a.file"), IsOk());
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THAT(decode(whole.substr(0, size), "a.file"), HasError("a.file: ")) << size;
  std::mt19937 random(3);
  const LimitedMemory limit(std::size_t{1} << 30);
  for (int k = 0; k < 2000; ++k) {
    std::string changed = whole;
    for (int i = 0; i <= k % 3; ++i)
      changed[random() % changed.size()] = static_cast<char>(random() % 256);
    (void)decode(changed, "a.file");
  }
}

template <typename... Numbers>
inline std::string bytes_of(Numbers... numbers) {
  std::string bytes;
  (append_little_endian(bytes, numbers), ...);
  return bytes;
}

inline std::string bmp(std::int32_t width, std::int32_t height, int bits,
                       const std::string& palette, const std::string& pixels,
                       std::uint32_t compression = 0) {
  const auto at = static_cast<std::uint32_t>(54 + palette.size());
  return "BM" +
         bytes_of(static_cast<std::uint32_t>(at + pixels.size()), std::uint32_t{0}, at,
                  std::uint32_t{40}, width, height, std::uint16_t{1},
                  static_cast<std::uint16_t>(bits), compression, std::uint32_t{0}, std::int32_t{0},
                  std::int32_t{0},
                  static_cast<std::uint32_t>(compression == 3 ? 0 : palette.size() / 4),
                  std::uint32_t{0}) +
         palette + pixels;
}

// Colours 0 to 3 are the greys 0, 10, 20 and 30.
inline std::string grey_palette() {
  std::string palette;
  for (int i = 0; i < 4; ++i) palette += std::string(3, static_cast<char>(10 * i)) + '\0';
  return palette;
}

// Blue, green and red of two rows of two pixels, and two bytes that fill a row up.
inline const std::string kBmpRows("\1\2\3\4\5\6\0\0\7\10\11\12\13\14\0\0", 16);

inline std::string tga(int type, int width, int height, int bits, int attributes,
                       const std::string& pixels, const std::string& palette = "", int colours = 0,
                       int colour_bits = 0) {
  const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
  const auto word = [](int value) { return static_cast<std::uint16_t>(value); };
  return bytes_of(byte(3), byte(palette.empty() ? 0 : 1), byte(type), word(0), word(colours),
                  byte(colour_bits), word(0), word(0), word(width), word(height), byte(bits),
                  byte(attributes)) +
         "id." + palette + pixels;
}

inline std::string hdr(const std::string& size, const std::string& pixels) {
  return "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n" + size + "\n" + pixels;
}

// Two pixels: mantissas times 2 to the exponent less 136.
inline const std::string kTwoHdrPixels("\x80\x40\x20\x81\0\0\0\0", 8);

}  // namespace relief::testing
