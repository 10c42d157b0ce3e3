#include "scan/io/images/codecs/floats/colmap_array.h"

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

// Takes a number and the `&` after it off `rest`.
bool take_array_size(std::string_view& rest, std::size_t& value) {
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  const auto length = static_cast<std::size_t>(end - rest.data());
  if (error != std::errc() || length >= rest.size() || *end != '&') return false;
  rest.remove_prefix(length + 1);
  return true;
}

float little_endian_float(const char* bytes) {
  std::uint32_t bits;
  std::memcpy(&bits, bytes, sizeof bits);
  if constexpr (std::endian::native == std::endian::big) bits = __builtin_bswap32(bits);
  return std::bit_cast<float>(bits);
}

}  // namespace

Result<Image> decode_colmap_array(std::string_view content, const std::filesystem::path& path) {
  std::string_view rest = content;
  std::size_t width = 0, height = 0, channels = 0;
  if (!take_array_size(rest, width) || !take_array_size(rest, height) ||
      !take_array_size(rest, channels))
    return bad_input(path,
                     "byte 0: expected 'width&height&channels&', the header of a depth or normal "
                     "map of COLMAP; is it another kind of .bin file?");
  if (channels != 1 && channels != 3)
    return bad_input(path, "the header says " + std::to_string(channels) +
                               " channels; a depth map has 1, a normal map has 3");
  const ImageHeader header{width, height, 32 * channels, channels};
  if (auto checked = check_image_header(header, content.size(), path); !checked)
    return checked.error();
  const std::size_t pixels = width * height, bytes = pixels * channels * sizeof(float);
  if (rest.size() != bytes)
    return bad_input(path, "the header says " + std::to_string(bytes) + " bytes of pixels, " +
                               std::to_string(rest.size()) +
                               " follow; it is damaged: copy it again, or run patch_match_stereo");
  Image image(static_cast<int>(width), static_cast<int>(height), static_cast<int>(channels));
  for (std::size_t c = 0; c < channels; ++c) {
    const char* plane = rest.data() + c * pixels * sizeof(float);
    for (std::size_t i = 0; i < pixels; ++i)
      image.samples[i * channels + c] = little_endian_float(plane + i * sizeof(float));
  }
  return image;
}

Result<Image> read_colmap_array(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return content.error();
  return decode_colmap_array(*content, path);
}

}  // namespace relief
