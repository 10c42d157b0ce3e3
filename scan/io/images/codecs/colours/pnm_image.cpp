// Netpbm's grey and colour maps: P2 and P3 in text, P5 and P6 in bytes of 8 or 16 bits.
#include <charconv>

#include "scan/io/files/io_error.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

bool is_pnm_space(char c) {
  return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\v' || c == '\f';
}

// Takes the next number off; comments run from `#` to the end of their line.
bool take_number(std::string_view& rest, std::size_t& value) {
  while (!rest.empty() && (is_pnm_space(rest.front()) || rest.front() == '#')) {
    if (rest.front() == '#') rest.remove_prefix(std::min(rest.find('\n'), rest.size() - 1));
    rest.remove_prefix(1);
  }
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (error != std::errc()) return false;
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return true;
}

bool read_text_samples(std::string_view rest, std::size_t largest, Image& image) {
  for (float& sample : image.samples) {
    std::size_t value = 0;
    if (!take_number(rest, value) || value > largest) return false;
    sample = static_cast<float>(value);
  }
  return true;
}

// 16-bit samples have their more significant byte first.
void read_byte_samples(std::string_view bytes, bool wide, Image& image) {
  for (std::size_t i = 0; i < image.samples.size(); ++i) {
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
    image.samples[i] = wide ? static_cast<float>(256 * byte(2 * i) + byte(2 * i + 1))
                            : static_cast<float>(byte(i));
  }
}

}  // namespace

Result<Image> decode_pnm(std::string_view content, const std::filesystem::path& path) {
  const std::string_view magic = content.substr(0, 2);
  const bool text = magic == "P2" || magic == "P3", bytes = magic == "P5" || magic == "P6";
  if (!text && !bytes) return bad_input(path, "not a grey or colour PNM file (no P2, P3, P5, P6)");
  std::string_view rest = content.substr(2);
  std::size_t width = 0, height = 0, largest = 0;
  if (!take_number(rest, width) || !take_number(rest, height) || !take_number(rest, largest) ||
      largest == 0 || largest > 65535)
    return bad_input(path, "bad PNM header; expected width, height and a largest value to 65535");
  const std::size_t channels = magic == "P3" || magic == "P6" ? 3 : 1;
  const bool wide = largest > 255;
  // In text a sample takes two bytes at least, a digit and a blank.
  const std::size_t bits = (text || wide ? 16 : 8) * channels;
  if (auto checked = check_image_header({width, height, bits, channels}, content.size(), path);
      !checked)
    return checked.error();
  Image image(static_cast<int>(width), static_cast<int>(height), static_cast<int>(channels),
              wide ? 65535 : 255);
  if (text && !read_text_samples(rest, largest, image))
    return bad_input(path, "truncated, or a sample is no number up to " + std::to_string(largest));
  const std::size_t needed = image.samples.size() * (wide ? 2 : 1);
  if (bytes && rest.size() < needed + 1)
    return bad_input(path, "truncated: " + std::to_string(needed) + " bytes of pixels expected, " +
                               std::to_string(rest.empty() ? 0 : rest.size() - 1) + " found");
  if (bytes) read_byte_samples(rest.substr(1), wide, image);
  return image;
}

}  // namespace relief
