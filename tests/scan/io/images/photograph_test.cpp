#include <cstdio>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <jpeglib.h>

#include "scan/io/images/image_io.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::TemporaryFolder;

// A ramp in both directions as a JPEG of the best quality without subsampling.
std::string ramp_jpeg(int width, int height, int channels, bool progressive) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = channels;
  jpeg.in_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 100, TRUE);
  for (int c = 0; c < jpeg.num_components; ++c)
    jpeg.comp_info[c].h_samp_factor = jpeg.comp_info[c].v_samp_factor = 1;
  if (progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<unsigned char> row(static_cast<std::size_t>(width * channels));
  for (int v = 0; v < height; ++v) {
    for (int i = 0; i < width * channels; ++i)
      row[static_cast<std::size_t>(i)] = static_cast<unsigned char>(4 * (i / channels) + 2 * v);
    unsigned char* pointer = row.data();
    jpeg_write_scanlines(&jpeg, &pointer, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  const std::string content(reinterpret_cast<const char*>(bytes), size);
  std::free(bytes);
  return content;
}

TEST(Photograph, JpegIsReadGreyAndInColour) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3}) {
    for (const bool progressive : {false, true}) {
      const auto image =
          value_of(read_image(folder.write("a.jpg", ramp_jpeg(20, 13, channels, progressive))));
      EXPECT_EQ(image.width, 20);
      EXPECT_EQ(image.height, 13);
      EXPECT_EQ(image.channels, channels);
      EXPECT_EQ(image.max_value, 255.0);
      for (int v = 0; v < 13; ++v)
        for (int u = 0; u < 20; ++u) EXPECT_NEAR(image(u, v), 4 * u + 2 * v, 3.0);
    }
  }
}

TEST(Photograph, ADamagedJpegIsAnError) {
  const TemporaryFolder folder;
  const std::string whole = ramp_jpeg(40, 40, 3, false);
  for (std::size_t size = 0; size + 2 < whole.size(); size += 1 + size / 20) {
    EXPECT_THAT(read_image(folder.write("a.jpg", whole.substr(0, size))), HasError("damaged JPEG"))
        << size;
  }
  EXPECT_THAT(read_image(folder.write("a.jpg", ramp_jpeg(8, 8, 4, false))),
              HasError("save it as grey or RGB"));
}

TEST(Photograph, PnmIsReadInTextAndBytes) {
  const TemporaryFolder folder;
  const auto values = [&](const char* name, const std::string& content) {
    return value_of(read_image(folder.write(name, content))).samples;
  };
  EXPECT_EQ(values("a.pgm", "P2\n# a comment\n3 1 # another\n255\n1 2 255\n"),
            (std::vector<float>{1, 2, 255}));
  EXPECT_EQ(values("a.ppm", "P3 1 1 300 1 2 300"), (std::vector<float>{1, 2, 300}));
  EXPECT_EQ(values("a.pgm", std::string("P5 2 1 255\n\x07\xff", 13)), (std::vector<float>{7, 255}));
  EXPECT_EQ(values("a.pgm", std::string("P5 1 1 65535\n\x01\x02", 15)), (std::vector<float>{258}));
}

TEST(Photograph, ADamagedPnmIsAnError) {
  const TemporaryFolder folder;
  for (const char* content :
       {"P4 1 1\n1", "P5 2 2 255\nab", "P5 2 2 0\nabcd", "P5 2 2 70000\nabcd", "P2 2 1 9\n1 10",
        "P2 2 1 9\n1", "P5", "P5 99999999 9999999 255\n", "P2 # no end"}) {
    EXPECT_THAT(read_image(folder.write("a.pgm", content)), HasError()) << content;
  }
}

}  // namespace
}  // namespace relief
