#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/result.h"
#include "scan/io/images/image_size.h"

namespace relief {

/// An image of one or three channels as it stands in its file; four, the last one the opacity,
/// where it is to be written.
struct Image {
  int width = 0, height = 0, channels = 0;
  /// 255 or 65535 when the samples are integers; 0 when they are real numbers.
  double max_value = 0.0;
  std::vector<float> samples;  ///< Row by row from the top, channels interleaved.

  Image() = default;
  Image(int columns, int rows, int channel_count, double max = 0.0)
      : width(columns),
        height(rows),
        channels(channel_count),
        max_value(max),
        samples(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) *
                static_cast<std::size_t>(channel_count)) {}

  std::size_t index(int u, int v, int channel = 0) const {
    return (static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(u)) *
               static_cast<std::size_t>(channels) +
           static_cast<std::size_t>(channel);
  }
  float operator()(int u, int v, int channel = 0) const { return samples[index(u, v, channel)]; }
  float& operator()(int u, int v, int channel = 0) { return samples[index(u, v, channel)]; }
};

/// Reads an image by its ending: .png (8 or 16 bit), .tif/.tiff (8 or 16 bit integer; 16, 32 or 64
/// bit float), .exr (half or float), .pfm, .jpg, .pgm/.ppm/.pnm, .bmp, .tga, .hdr, .webp, .npy,
/// .bin of COLMAP, .raw/.f32 (bare floats, which need `size`). A `size` given for another ending
/// must be that of the image. Alpha channels are dropped, palettes resolved. Truncated and corrupt
/// files are errors (kBadInput). Nothing is allocated that check_image_header() (see
/// image_limits.h) does not allow.
Result<Image> read_image(const std::filesystem::path& path,
                         const std::optional<ImageSize>& size = std::nullopt);

/// The same of a depth map, which has one channel. Three that are all the same, as OpenCV writes
/// them, are one; other colours are an error (kBadInput).
Result<Image> read_depth_image(const std::filesystem::path& path,
                               const std::optional<ImageSize>& size = std::nullopt);

/// The bytes of a 32-bit float TIFF, deflated, of a real image.
Result<std::string> encode_tiff(const Image& image);

/// A remark in a PNG: a keyword of 1 to 79 Latin letters, such as `Description`, and its text.
struct PngText {
  std::string keyword, text;
};

/// The bytes of a PNG of an integer image: 8 bits a sample when `max_value` is 255, 16 when 65535.
Result<std::string> encode_png(const Image& image, const std::vector<PngText>& texts = {});

/// The codecs behind read_image, on the content of `path`.
Result<Image> decode_png(std::string_view content, const std::filesystem::path& path);
Result<Image> decode_tiff(std::string_view content, const std::filesystem::path& path);
Result<Image> decode_exr(std::string_view content, const std::filesystem::path& path);
Result<Image> decode_pfm(std::string_view content, const std::filesystem::path& path);
Result<Image> decode_jpeg(std::string_view content, const std::filesystem::path& path);
Result<Image> decode_pnm(std::string_view content, const std::filesystem::path& path);
Result<Image> decode_bmp(std::string_view content, const std::filesystem::path& path);
Result<Image> decode_tga(std::string_view content, const std::filesystem::path& path);
Result<Image> decode_hdr(std::string_view content, const std::filesystem::path& path);
Result<Image> decode_webp(std::string_view content, const std::filesystem::path& path);
Result<Image> decode_npy(std::string_view content, const std::filesystem::path& path);

}  // namespace relief
