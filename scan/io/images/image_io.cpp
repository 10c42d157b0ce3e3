#include "scan/io/images/image_io.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/floats/colmap_array.h"
#include "scan/io/images/codecs/floats/raw_floats.h"

namespace relief {

namespace {

using Decoder = Result<Image> (*)(std::string_view content, const std::filesystem::path& path);

struct ImageFormat {
  const char* ending;
  Decoder decode;
};

constexpr std::array kImageFormats{
    ImageFormat{".png", decode_png},   ImageFormat{".tif", decode_tiff},
    ImageFormat{".tiff", decode_tiff}, ImageFormat{".exr", decode_exr},
    ImageFormat{".pfm", decode_pfm},   ImageFormat{".jpg", decode_jpeg},
    ImageFormat{".jpeg", decode_jpeg}, ImageFormat{".pgm", decode_pnm},
    ImageFormat{".ppm", decode_pnm},   ImageFormat{".pnm", decode_pnm},
    ImageFormat{".bmp", decode_bmp},   ImageFormat{".tga", decode_tga},
    ImageFormat{".hdr", decode_hdr},   ImageFormat{".webp", decode_webp},
    ImageFormat{".npy", decode_npy},   ImageFormat{".bin", decode_colmap_array}};

Decoder decoder_of(const std::string& ending) {
  for (const ImageFormat& format : kImageFormats)
    if (ending == format.ending) return format.decode;
  return nullptr;
}

Result<Image> read_raw_floats(const std::filesystem::path& path,
                              const std::optional<ImageSize>& size) {
  if (!size)
    return bad_input(path,
                     "a file of bare floats does not tell its size; name it in a scan.json and add "
                     "\"size\": [WIDTH, HEIGHT] beside \"file\"");
  const auto content = read_file(path);
  if (!content) return content.error();
  return decode_raw_floats(*content, *size, path);
}

}  // namespace

Result<Image> read_image(const std::filesystem::path& path, const std::optional<ImageSize>& size) {
  if (has_raw_ending(path)) return read_raw_floats(path, size);
  const std::string ending = lower_ending(path);
  const Decoder decode = decoder_of(ending);
  if (!decode)
    return bad_input(path, "unknown image format '" + ending +
                               "'; use .png, .tiff, .exr, .pfm, .jpg, .pgm, .ppm, .bmp, .tga, "
                               ".hdr, .webp, .npy, .raw, or the .bin of COLMAP");
  const auto content = read_file(path);
  if (!content) return content.error();
  auto image = decode(*content, path);
  if (image && size && *size != ImageSize{image->width, image->height})
    return bad_input(path, "is " + std::to_string(image->width) + "x" +
                               std::to_string(image->height) + " pixels, but its \"size\" is " +
                               std::to_string(size->width) + "x" + std::to_string(size->height));
  return image;
}

Result<Image> read_depth_image(const std::filesystem::path& path,
                               const std::optional<ImageSize>& size) {
  auto image = read_image(path, size);
  if (!image || image->channels == 1) return image;
  Image depth(image->width, image->height, 1, image->max_value);
  const auto channels = static_cast<std::size_t>(image->channels);
  for (std::size_t i = 0; i < depth.samples.size(); ++i) {
    const float* pixel = image->samples.data() + channels * i;
    if (!std::all_of(pixel, pixel + channels,
                     [&](float z) { return z == *pixel || (std::isnan(z) && std::isnan(*pixel)); }))
      return bad_input(path, "a depth map has one channel, this image has three colours");
    depth.samples[i] = *pixel;
  }
  return depth;
}

}  // namespace relief
