#include "scan/io/images/image_limits.h"

#include <cstdint>
#include <cstring>
#include <initializer_list>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfPreviewImage.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/files/atomic_file.h"
#include "scan/io/images/image_io.h"
#include "tests/support/limited_memory.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::LimitedMemory;
using testing::TemporaryFolder;

constexpr std::size_t kGiga = std::size_t{1} << 30;

bool allowed(const ImageHeader& header, std::size_t file_bytes, std::size_t memory = 100 * kGiga) {
  return check_image_header(header, file_bytes, "a", memory).ok();
}

TEST(ImageLimits, FollowTheCompression) {
  EXPECT_TRUE(allowed({1000, 1000, 32, 1, kUncompressed}, 4'000'000));
  EXPECT_FALSE(allowed({1000, 1000, 32, 1, kUncompressed}, 3'999'999));
  EXPECT_TRUE(allowed({1000, 1000, 16, 1, kDeflate}, 2'000'000 / 1032));
  EXPECT_FALSE(allowed({1000, 1000, 16, 1, kDeflate}, 2'000'000 / 1032 - 1));
}

TEST(ImageLimits, LetMasksOfLargeCamerasBeSmallFiles) {
  EXPECT_TRUE(allowed({8192, 8192, 1, 1, kDeflate}, 20'000));
  EXPECT_FALSE(allowed({16384, 16384, 1, 1, kDeflate}, 65'000));
  EXPECT_TRUE(allowed({16384, 16384, 1, 1, kDeflate}, 1 << 20));
}

TEST(ImageLimits, FollowTheMemory) {
  const ImageHeader header{4096, 4096, 8, 1, kDeflate};
  EXPECT_TRUE(allowed(header, 1 << 20, std::size_t{80} << 20));
  EXPECT_THAT(check_image_header(header, 1 << 20, "mask.png", std::size_t{79} << 20),
              HasError(ErrorKind::kUnsolvable, "mask.png: 4096x4096 pixels take 81 MiB"));
}

void put_big_endian(std::string& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t k = 0; k < 4; ++k) bytes[at + k] = static_cast<char>(value >> (24 - 8 * k));
}

std::uint32_t crc_of(std::string_view bytes) {
  std::uint32_t crc = ~0u;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int k = 0; k < 8; ++k) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

// A file of 65 kB whose header says 2^28 pixels.
TEST(ImageLimits, HoldForPng) {
  std::string png = *encode_png(Image(4, 4, 1, 65535));
  put_big_endian(png, 16, 65536);
  put_big_endian(png, 20, 4096);
  put_big_endian(png, 29, crc_of(std::string_view(png).substr(12, 17)));
  png.resize(65'000);
  const LimitedMemory limit(kGiga / 4);
  EXPECT_THAT(decode_png(png, "a.png"), HasError("far more than a file of 65000 bytes"));
}

// The value of a tag of one number, in the first directory.
void set_tiff_tag(std::string& tiff, std::uint16_t tag, std::uint32_t value) {
  std::uint32_t directory = 0;
  std::memcpy(&directory, tiff.data() + 4, 4);
  std::uint16_t count = 0;
  std::memcpy(&count, tiff.data() + directory, 2);
  for (std::size_t at = directory + 2; count > 0; --count, at += 12) {
    std::uint16_t found = 0;
    std::memcpy(&found, tiff.data() + at, 2);
    const std::uint16_t whole = 4;
    if (found != tag) continue;
    std::memcpy(tiff.data() + at + 2, &whole, 2);
    std::memcpy(tiff.data() + at + 8, &value, 4);
  }
}

TEST(ImageLimits, HoldForTiff) {
  std::string tiff = *encode_tiff(Image(4, 4, 1));
  set_tiff_tag(tiff, 256, 65536);
  set_tiff_tag(tiff, 257, 4096);
  tiff.resize(65'000);
  const LimitedMemory limit(kGiga / 4);
  EXPECT_THAT(decode_tiff(tiff, "a.tif"), HasError("far more than a file of 65000"));
}

std::string exr_with(Imf::Header header) {
  const TemporaryFolder folder;
  const auto path = folder / "a.exr";
  if (header.channels().begin() == header.channels().end())
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
  std::vector<float> pixel(static_cast<std::size_t>(header.dataWindow().max.x) + 1);
  Imf::FrameBuffer frame;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
    frame.insert(channel.name(),
                 Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(pixel.data()), 4, 0));
  {
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(header.dataWindow().max.y + 1);
  }
  return *read_file(path);
}

// Replaces numbers of an attribute, from the first on.
std::string with_attribute(std::string exr, const std::string& name_and_type,
                           std::initializer_list<std::int32_t> numbers) {
  std::size_t at = exr.find(name_and_type) + name_and_type.size() + 4;
  for (const std::int32_t number : numbers) {
    std::memcpy(exr.data() + at, &number, 4);
    at += 4;
  }
  return exr;
}

const std::string kDataWindow("dataWindow\0box2i\0", 17);

TEST(ImageLimits, HoldForExrBeforeItIsOpened) {
  const std::string exr = exr_with(Imf::Header(4, 4));
  ASSERT_THAT(decode_exr(exr, "a.exr"), IsOk());
  const LimitedMemory limit(kGiga / 4);
  const auto decode = [&](std::initializer_list<std::int32_t> window) {
    std::string changed = with_attribute(exr, kDataWindow, window);
    changed.resize(65'000);
    return decode_exr(changed, "a.exr");
  };
  EXPECT_THAT(decode({0, 0, 65535, 4095}), HasError("far more than a file of 65000 bytes"));
  EXPECT_THAT(decode({-2000000000, 0, 2000000000, 3}), HasError("more than can be read"));
  EXPECT_THAT(decode({0, 0, 3, 2000000000}), HasError("more than can be read"));
  EXPECT_THAT(decode({0, 0, 3, 65535}), HasError("blocks of pixels"));
  EXPECT_THAT(decode({0, 0, -1, 3}), HasError("is empty"));
}

TEST(ImageLimits, HoldForWhatExrUnpacksAtOnce) {
  Imf::Header header(4, 1);
  header.compression() = Imf::DWAB_COMPRESSION;
  for (int c = 0; c < 2000; ++c)
    header.channels().insert("c" + std::to_string(c), Imf::Channel(Imf::FLOAT));
  const std::string exr = with_attribute(exr_with(header), kDataWindow, {0, 0, 65535, 0});
  const LimitedMemory limit(kGiga);
  EXPECT_THAT(decode_exr(exr, "a.exr"), HasError("packed in blocks of 65536x256"));
}

TEST(ImageLimits, HoldForThePreviewOfExr) {
  Imf::Header header(4, 4);
  header.setPreviewImage(Imf::PreviewImage(2, 2));
  const std::string exr = exr_with(header);
  ASSERT_THAT(decode_exr(exr, "a.exr"), IsOk());
  const std::string changed =
      with_attribute(exr, std::string("preview\0preview\0", 16), {60000, 60000});
  const LimitedMemory limit(kGiga);
  EXPECT_THAT(decode_exr(changed, "a.exr"), HasError("OpenEXR header, byte "));
}

}  // namespace
}  // namespace relief
