// The one file that meets libwebp.
#include <cstdint>
#include <string>
#include <vector>

#include <webp/decode.h>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/little_endian.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

constexpr std::size_t kRiffBytes = 12;
// The format has no bound: one colour takes no bits a pixel. Its encoder leaves a byte for 102,000.
constexpr std::size_t kWebp = 1u << 17;

const std::uint8_t* webp_bytes(std::string_view content) {
  return reinterpret_cast<const std::uint8_t*>(content.data());
}

Error damaged_webp(const std::filesystem::path& path) {
  return bad_input(path, "damaged or truncated WebP; copy or save it again");
}

// Sizes and the kind of file; the file is there as a whole, by the size it tells.
Result<WebPBitstreamFeatures> read_webp_header(std::string_view content,
                                               const std::filesystem::path& path) {
  if (content.size() < kRiffBytes || !content.starts_with("RIFF") || content.substr(8, 4) != "WEBP")
    return bad_input(path, "not a WebP file");
  const std::size_t file_bytes = 8 + std::size_t{little_endian_at<std::uint32_t>(content, 4)};
  if (file_bytes > content.size())
    return bad_input(path, "truncated: " + std::to_string(file_bytes) + " bytes expected, " +
                               std::to_string(content.size()) + " found; copy it again");
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(webp_bytes(content), content.size(), &features) != VP8_STATUS_OK)
    return damaged_webp(path);
  if (features.has_animation)
    return bad_input(path, "an animation; save its first picture as .webp or .png");
  return features;
}

}  // namespace

// No colour is multiplied by alpha.
Result<Image> decode_webp(std::string_view content, const std::filesystem::path& path) {
  const auto features = read_webp_header(content, path);
  if (!features) return features.error();
  const auto width = static_cast<std::size_t>(features->width);
  const auto height = static_cast<std::size_t>(features->height);
  if (auto checked = check_image_header({width, height, 32, 3, kWebp}, content.size(), path);
      !checked)
    return checked.error();
  std::vector<std::uint8_t> bytes(width * height * 3);
  if (!WebPDecodeRGBInto(webp_bytes(content), content.size(), bytes.data(), bytes.size(),
                         3 * features->width))
    return damaged_webp(path);
  Image image(features->width, features->height, 3, 255.0);
  image.samples.assign(bytes.begin(), bytes.end());
  return image;
}

}  // namespace relief
