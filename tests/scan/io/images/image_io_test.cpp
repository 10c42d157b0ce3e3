#include "scan/io/images/image_io.h"

#include <cstring>
#include <limits>
#include <random>
#include <tuple>

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiffio.h>

#include "scan/io/files/atomic_file.h"
#include "tests/support/limited_memory.h"
#include "tests/support/parameter_names.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;

// Every sample different.
Image ramp(int width, int height, int channels, double max_value, float step) {
  Image image(width, height, channels, max_value);
  for (std::size_t i = 0; i < image.samples.size(); ++i)
    image.samples[i] = static_cast<float>(i) * step;
  return image;
}

void expect_same(const Result<Image>& read, const Image& expected) {
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(read->width, expected.width);
  EXPECT_EQ(read->height, expected.height);
  EXPECT_EQ(read->channels, expected.channels);
  EXPECT_EQ(read->max_value, expected.max_value);
  EXPECT_EQ(read->samples, expected.samples);
}

TEST(ImageIo, PngKeepsAllIntegers) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3}) {
    for (const bool wide : {false, true}) {
      const Image image = ramp(7, 5, channels, wide ? 65535 : 255, wide ? 600.0f : 2.0f);
      const auto path = folder.write("a.png", *encode_png(image));
      expect_same(read_image(path), image);
    }
  }
}

TEST(ImageIo, PngIsWrittenWithOpacityAndRemarks) {
  const TemporaryFolder folder;
  const Image image = ramp(7, 5, 4, 255, 1.0f);
  const std::string bytes =
      *encode_png(image, {{"Software", "relief"}, {"Description", "range: 1 to 2"}});
  EXPECT_EQ(bytes[25], 6);  // IHDR: colours with opacity
  EXPECT_THAT(bytes, HasSubstr("Description"));
  EXPECT_THAT(bytes, HasSubstr("range: 1 to 2"));
  const auto read = value_of(read_image(folder.write("a.png", bytes)));
  ASSERT_EQ(read.channels, 3);  // the opacity is dropped
  for (int k = 0; k < 3; ++k) EXPECT_EQ(read(3, 2, k), image(3, 2, k));
}

TEST(ImageIo, TiffKeepsAllFloats) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3}) {
    Image image = ramp(97, 61, channels, 0.0, 1.37f);
    image.samples[3] = -1e-30f;
    image.samples[4] = std::numeric_limits<float>::infinity();
    expect_same(read_image(folder.write("a.tiff", *encode_tiff(image))), image);
  }
}

template <typename T>
void write_tiff(const std::filesystem::path& path, const Image& image, int format, bool tiled,
                bool separate) {
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, image.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, image.height);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, image.channels);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8 * sizeof(T));
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, format);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_LZW);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, separate ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  const int planes = separate ? image.channels : 1;
  const int in_block = separate ? 1 : image.channels;
  const int block = 16;
  if (tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, block);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, block);
  }
  for (int plane = 0; plane < planes; ++plane) {
    const auto value = [&](int u, int v, int c) {
      return u < image.width && v < image.height ? static_cast<T>(image(u, v, separate ? plane : c))
                                                 : T();
    };
    const int width = tiled ? block : image.width, height = tiled ? block : 1;
    for (int v0 = 0; v0 < image.height; v0 += height) {
      for (int u0 = 0; u0 < image.width; u0 += width) {
        std::vector<T> data;
        for (int v = v0; v < v0 + height; ++v)
          for (int u = u0; u < u0 + width; ++u)
            for (int c = 0; c < in_block; ++c) data.push_back(value(u, v, c));
        if (tiled)
          TIFFWriteTile(tiff, data.data(), u0, v0, 0, plane);
        else
          TIFFWriteScanline(tiff, data.data(), v0, plane);
      }
    }
  }
  TIFFClose(tiff);
}

TEST(ImageIo, TiffReadsStripsTilesPlanesAndAllSampleTypes) {
  const TemporaryFolder folder;
  const auto path = folder / "a.tif";
  for (const bool tiled : {false, true}) {
    for (const bool separate : {false, true}) {
      const Image integers = ramp(37, 23, 3, 65535, 7.0f);
      write_tiff<std::uint16_t>(path, integers, SAMPLEFORMAT_UINT, tiled, separate);
      expect_same(read_image(path), integers);
      const Image reals = ramp(37, 23, 3, 0.0, 0.37f);
      write_tiff<float>(path, reals, SAMPLEFORMAT_IEEEFP, tiled, separate);
      expect_same(read_image(path), reals);
      write_tiff<double>(path, reals, SAMPLEFORMAT_IEEEFP, tiled, separate);
      expect_same(read_image(path), reals);
    }
  }
  const Image bytes = ramp(10, 10, 1, 255, 2.0f);
  write_tiff<std::uint8_t>(path, bytes, SAMPLEFORMAT_UINT, false, false);
  expect_same(read_image(path), bytes);
}

// Where a stored pixel belongs, by TIFF 6.0: what row 0 and column 0 are on the upright image.
Image turned(const Image& stored, int orientation) {
  const bool swapped = orientation >= 5;
  const int width = swapped ? stored.height : stored.width;
  const int height = swapped ? stored.width : stored.height;
  Image image(width, height, stored.channels, stored.max_value);
  for (int v = 0; v < stored.height; ++v) {
    for (int u = 0; u < stored.width; ++u) {
      const int x = swapped ? v : u, y = swapped ? u : v;
      const bool right =
          orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
      const bool bottom =
          orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
      for (int c = 0; c < stored.channels; ++c)
        image(right ? width - 1 - x : x, bottom ? height - 1 - y : y, c) = stored(u, v, c);
    }
  }
  return image;
}

// Sets a tag of a file that is there.
void set_tag(const std::filesystem::path& path, std::uint32_t tag, std::uint16_t value) {
  TIFF* tiff = TIFFOpen(path.c_str(), "r+");
  TIFFSetField(tiff, tag, value);
  TIFFRewriteDirectory(tiff);
  TIFFClose(tiff);
}

class TiffInEveryOrientation : public ::testing::TestWithParam<std::tuple<int, std::uint16_t>> {};
INSTANTIATE_TEST_SUITE_P(ChannelsAndTag, TiffInEveryOrientation,
                         ::testing::Combine(::testing::Values(1, 3),
                                            ::testing::Range<std::uint16_t>(1, 9)),
                         testing::PrintedName());

TEST_P(TiffInEveryOrientation, IsTurnedUpright) {
  const auto [channels, orientation] = GetParam();
  const TemporaryFolder folder;
  const auto path = folder / "a.tif";
  const Image stored = ramp(5, 3, channels, 65535, 7.0f);
  write_tiff<std::uint16_t>(path, stored, SAMPLEFORMAT_UINT, false, false);
  set_tag(path, TIFFTAG_ORIENTATION, orientation);
  expect_same(read_image(path), turned(stored, orientation));
}

TEST(ImageIo, TiffWhoseLeastIsWhiteIsInverted) {
  const TemporaryFolder folder;
  const auto path = folder / "a.tif";
  Image image = ramp(5, 3, 1, 255, 7.0f);
  write_tiff<std::uint8_t>(path, image, SAMPLEFORMAT_UINT, false, false);
  set_tag(path, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISWHITE);
  for (float& sample : image.samples) sample = 255.0f - sample;
  expect_same(read_image(path), image);
}

TEST(ImageIo, TiffOfAnotherMeaningIsRefusedWithARemedy) {
  const TemporaryFolder folder;
  const auto path = folder / "a.tif";
  const auto read = [&](std::uint16_t photometric) {
    set_tag(path, TIFFTAG_PHOTOMETRIC, photometric);
    return read_image(path);
  };
  write_tiff<float>(path, ramp(5, 3, 1, 0.0, 0.37f), SAMPLEFORMAT_IEEEFP, false, false);
  EXPECT_THAT(read(PHOTOMETRIC_MINISWHITE), HasError("save it with the least as black"));
  write_tiff<std::uint8_t>(path, ramp(5, 3, 1, 255, 2.0f), SAMPLEFORMAT_UINT, false, false);
  EXPECT_THAT(read(PHOTOMETRIC_SEPARATED), HasError("interpretation is 5; save it as grey"));
  EXPECT_THAT(read(PHOTOMETRIC_CIELAB), HasError("a.tif: unsupported TIFF"));
}

TEST(ImageIo, TiffPaletteIsRefusedWithARemedy) {
  const TemporaryFolder folder;
  const auto path = folder / "a.tif";
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 4);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_PALETTE);
  std::vector<std::uint16_t> map(256, 500);
  TIFFSetField(tiff, TIFFTAG_COLORMAP, map.data(), map.data(), map.data());
  std::uint8_t row[4] = {0, 1, 2, 3};
  TIFFWriteScanline(tiff, row, 0, 0);
  TIFFClose(tiff);
  EXPECT_THAT(read_image(path), HasError("colour palette", "save it as grey or RGB"));
}

TEST(ImageIo, PfmReadsBothByteOrdersFromTheBottomUp) {
  const TemporaryFolder folder;
  const float values[] = {1.5f, -2.0f, 3.0f, 4.0f};
  std::string little, big;
  for (const float value : values) {
    char bytes[4];
    std::memcpy(bytes, &value, 4);
    little.append(bytes, 4);
    big.append({bytes[3], bytes[2], bytes[1], bytes[0]});
  }
  Image expected(2, 2, 1);
  expected.samples = {3.0f, 4.0f, 1.5f, -2.0f};
  expect_same(read_image(folder.write("a.pfm", "Pf\n2 2\n-1.0\n" + little)), expected);
  expect_same(read_image(folder.write("b.pfm", "Pf\n2 2\n1.0\n" + big)), expected);
  EXPECT_THAT(read_image(folder.write("c.pfm", "Pf\n2 2\n0\n" + big)), HasError());
  EXPECT_THAT(read_image(folder.write("d.pfm", "Pf\n2 3\n1.0\n" + big)), HasError());
}

void write_exr(const std::filesystem::path& path, const std::vector<std::string>& channels,
               const Image& image) {
  Imf::Header header(image.width, image.height);
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    header.channels().insert(channels[c], Imf::Channel(Imf::FLOAT));
    const auto stride = sizeof(float) * channels.size();
    frame.insert(channels[c],
                 Imf::Slice(Imf::FLOAT,
                            reinterpret_cast<char*>(const_cast<float*>(image.samples.data() + c)),
                            stride, stride * static_cast<std::size_t>(image.width)));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(frame);
  file.writePixels(image.height);
}

TEST(ImageIo, ExrReadsDepthAndNormals) {
  const TemporaryFolder folder;
  const auto path = folder / "a.exr";
  const Image depth = ramp(20, 11, 1, 0.0, 0.7f), normals = ramp(20, 11, 3, 0.0, 0.01f);
  for (const char* channel : {"Z", "Y", "R", "distance"}) {
    write_exr(path, {channel}, depth);
    expect_same(read_image(path), depth);
    EXPECT_EQ(image_size(path), (ImageSize{20, 11}));
  }
  write_exr(path, {"R", "G", "B"}, normals);
  expect_same(read_image(path), normals);
  write_exr(path, {"A", "B", "C"}, normals);
  EXPECT_THAT(read_image(path), HasError("no channel to read"));
}

TEST(ImageIo, DamagedExrFilesAreErrorsNotCrashes) {
  const TemporaryFolder folder;
  write_exr(folder / "a.exr", {"R", "G", "B"}, ramp(20, 11, 3, 0.0, 0.01f));
  const std::string content = *read_file(folder / "a.exr");
  for (std::size_t size = 0; size < content.size(); size += size < 500 ? 1 : 13)
    EXPECT_THAT(decode_exr(content.substr(0, size), "a.exr"), HasError()) << size;
  std::mt19937 random(5);
  for (int k = 0; k < 3000; ++k) {
    std::string changed = content;
    const std::size_t range = k % 2 ? changed.size() : std::min<std::size_t>(400, changed.size());
    changed[random() % range] = static_cast<char>(random() % 256);
    (void)decode_exr(changed, "a.exr");
  }
}

TEST(ImageIo, ALyingHeaderIsRefusedBeforeMemoryIsTaken) {
  const TemporaryFolder folder;
  EXPECT_THAT(read_image(folder.write("a.pfm", "Pf\n60000 4000\n-1\nxxxx")), HasError("truncated"));
  EXPECT_THAT(read_image(folder.write("b.pfm", "Pf\n99999999 99999999\n-1\nxxxx")), HasError());
  EXPECT_THAT(read_image(folder.write("c.pfm", "Pf\n0 5\n-1\n")), HasError());
}

TEST(ImageIo, UnknownAndMissingFilesAreNamed) {
  EXPECT_THAT(read_image("depth.gif"), HasError("depth.gif"));
  EXPECT_THAT(read_image("/no/such/depth.png"), HasError("/no/such/depth.png"));
}

}  // namespace
}  // namespace relief
