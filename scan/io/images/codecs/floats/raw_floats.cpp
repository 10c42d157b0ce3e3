#include "scan/io/images/codecs/floats/raw_floats.h"

#include <string>

#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/little_endian.h"
#include "scan/io/images/image_limits.h"

namespace relief {

bool has_raw_ending(const std::filesystem::path& path) {
  const std::string ending = lower_ending(path);
  return ending == ".raw" || ending == ".f32";
}

Result<Image> decode_raw_floats(std::string_view content, const ImageSize& size,
                                const std::filesystem::path& path) {
  const auto width = static_cast<std::size_t>(size.width > 0 ? size.width : 0);
  const auto height = static_cast<std::size_t>(size.height > 0 ? size.height : 0);
  if (auto checked = check_image_header({width, height, 32, 1}, content.size(), path); !checked)
    return checked.error();
  const std::size_t plane = width * height * sizeof(float);
  if (content.size() != plane && content.size() != 3 * plane)
    return bad_input(path, "a raw image of " + std::to_string(width) + "x" +
                               std::to_string(height) + " has " + std::to_string(plane) +
                               " bytes, or three times as many in colour; this file has " +
                               std::to_string(content.size()) + ": correct its \"size\"");
  const std::size_t channels = content.size() / plane;
  const ImageHeader header{width, height, 32 * channels, channels};
  if (auto checked = check_image_header(header, content.size(), path); !checked)
    return checked.error();
  Image image(size.width, size.height, static_cast<int>(channels));
  for (std::size_t i = 0; i < image.samples.size(); ++i)
    image.samples[i] = little_endian_at<float>(content, i * sizeof(float));
  return image;
}

}  // namespace relief
