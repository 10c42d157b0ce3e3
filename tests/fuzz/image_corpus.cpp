// Small images of each format, in each packing that its reader tells apart.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <jpeglib.h>
#include <tiffio.h>
#include <webp/encode.h>

#include "scan/io/images/image_io.h"
#include "tests/fuzz/corpus_folder.h"

namespace relief::testing {

namespace {

constexpr int kWidth = 9, kHeight = 7;  // pixels; no multiple of a block of any codec

Image ramp(int channels, double max_value) {
  Image image(kWidth, kHeight, channels, max_value);
  for (std::size_t i = 0; i < image.samples.size(); ++i)
    image.samples[i] = static_cast<float>(i % 200);
  return image;
}

std::vector<std::uint8_t> bytes_of_ramp(int channels) {
  const Image image = ramp(channels, 255.0);
  return {image.samples.begin(), image.samples.end()};
}

void add_exr(const CorpusFolder& corpus, const std::string& name, Imf::Compression compression) {
  Imf::Header header(kWidth, kHeight);
  header.compression() = compression;
  header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
  Image image = ramp(1, 0.0);
  Imf::FrameBuffer frame;
  frame.insert(
      "Z", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(image.samples.data()), 4, 4 * kWidth));
  Imf::OutputFile file(corpus.path_of("exr", name).c_str(), header);
  file.setFrameBuffer(frame);
  file.writePixels(kHeight);
}

void add_tiff(const CorpusFolder& corpus, const std::string& name, std::uint16_t compression) {
  TIFF* tiff = TIFFOpen(corpus.path_of("tiff", name).c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_RIGHTTOP);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression);
  std::vector<std::uint8_t> rows = bytes_of_ramp(1);
  for (std::uint32_t v = 0; v < kHeight; ++v) TIFFWriteScanline(tiff, &rows[v * kWidth], v, 0);
  TIFFClose(tiff);
}

void add_jpeg(const CorpusFolder& corpus, const std::string& name, bool progressive) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = kWidth;
  jpeg.image_height = kHeight;
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  if (progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<std::uint8_t> rows = bytes_of_ramp(3);
  for (int v = 0; v < kHeight; ++v) {
    unsigned char* row = &rows[static_cast<std::size_t>(3 * v * kWidth)];
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  corpus.add("jpeg", name, {reinterpret_cast<const char*>(bytes), size});
  std::free(bytes);
}

void add_webp(const CorpusFolder& corpus) {
  const std::vector<std::uint8_t> rows = bytes_of_ramp(3);
  for (const bool lossless : {false, true}) {
    std::uint8_t* bytes = nullptr;
    const std::size_t size =
        lossless ? WebPEncodeLosslessRGB(rows.data(), kWidth, kHeight, 3 * kWidth, &bytes)
                 : WebPEncodeRGB(rows.data(), kWidth, kHeight, 3 * kWidth, 80.0f, &bytes);
    corpus.add("webp", lossless ? "lossless.webp" : "lossy.webp",
               {reinterpret_cast<const char*>(bytes), size});
    WebPFree(bytes);
  }
}

void add_coded(const CorpusFolder& corpus) {
  for (const int channels : {1, 3}) {
    for (const double max_value : {255.0, 65535.0})
      corpus.add("png", std::to_string(channels) + "x" + std::to_string(int(max_value)) + ".png",
                 *encode_png(ramp(channels, max_value)));
    corpus.add("tiff", std::to_string(channels) + "_real.tiff", *encode_tiff(ramp(channels, 0.0)));
  }
  for (const std::uint16_t packing :
       {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_PACKBITS, COMPRESSION_DEFLATE})
    add_tiff(corpus, std::to_string(packing) + ".tiff", packing);
  for (const Imf::Compression packing :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION,
        Imf::PXR24_COMPRESSION, Imf::DWAA_COMPRESSION})
    add_exr(corpus, std::to_string(packing) + ".exr", packing);
  for (const bool progressive : {false, true})
    add_jpeg(corpus, progressive ? "progressive.jpg" : "baseline.jpg", progressive);
  add_webp(corpus);
}

// Images of five by four pixels, of a byte or a float each.
void add_plain(const CorpusFolder& corpus) {
  const std::string bytes(5 * 4, 'A'), floats(5 * 4 * 4, 'A');
  corpus.add("pfm", "a.pfm", "Pf\n5 4\n-1\n" + floats);
  corpus.add("pnm", "bytes.pgm", "P5\n5 4\n255\n" + bytes);
  corpus.add("pnm", "text.pgm", "P2\n2 2\n# a comment\n65535\n1 2\n3 4\n");
  corpus.add("raw", "a.raw", floats);
  corpus.add("hdr", "a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 5\n" + floats);
  corpus.add("tga", "a.tga", std::string("\0\0\3\0\0\0\0\0\0\0\0\0\5\0\4\0\10\0", 18) + bytes);
  corpus.add("bmp", "a.bmp",
             std::string("BM\x86\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\5\0\0\0\4\0\0\0\1\0\x20\0", 30) +
                 std::string(24, '\0') + floats);
  corpus.add("npy", "a.npy",
             std::string("\x93NUMPY\1\0\x39\0", 10) +
                 "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 5)}" + floats);
}

}  // namespace

void add_images(const CorpusFolder& corpus) {
  add_coded(corpus);
  add_plain(corpus);
}

}  // namespace relief::testing
