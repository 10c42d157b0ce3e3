#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "scan/io/files/io_error.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

// The next token of a PFM header; the one byte of white space after it is consumed too.
std::string_view next_token(std::string_view& rest) {
  const auto is_space = [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; };
  while (!rest.empty() && is_space(rest.front())) rest.remove_prefix(1);
  const auto end = std::find_if(rest.begin(), rest.end(), is_space);
  const std::string_view token = rest.substr(0, static_cast<std::size_t>(end - rest.begin()));
  rest.remove_prefix(std::min(rest.size(), token.size() + 1));
  return token;
}

template <typename T>
bool parse_all(std::string_view token, T& value) {
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  return error == std::errc() && end == token.data() + token.size();
}

float load_float(const char* bytes, bool little_endian) {
  std::uint32_t bits;
  std::memcpy(&bits, bytes, sizeof bits);
  if (little_endian != (std::endian::native == std::endian::little)) bits = __builtin_bswap32(bits);
  return std::bit_cast<float>(bits);
}

}  // namespace

Result<Image> decode_pfm(std::string_view content, const std::filesystem::path& path) {
  std::string_view rest = content;
  const std::string_view magic = next_token(rest);
  if (magic != "PF" && magic != "Pf") return bad_input(path, "not a PFM file (no PF or Pf)");
  std::size_t width = 0, height = 0;
  double scale = 0.0;
  if (!parse_all(next_token(rest), width) || !parse_all(next_token(rest), height) ||
      !parse_all(next_token(rest), scale) || !std::isfinite(scale) || scale == 0.0)
    return bad_input(path, "bad PFM header; expected width, height and a scale that is not 0");
  const std::size_t channels = magic == "PF" ? 3 : 1;
  const ImageHeader header{width, height, channels * 32, channels};
  if (auto checked = check_image_header(header, content.size(), path); !checked)
    return checked.error();
  const std::size_t row_values = width * channels;
  if (rest.size() < row_values * height * 4)
    return bad_input(path, "truncated: " + std::to_string(row_values * height * 4) +
                               " bytes of pixels expected, " + std::to_string(rest.size()) +
                               " found");
  Image image(static_cast<int>(width), static_cast<int>(height), static_cast<int>(channels));
  for (std::size_t v = 0; v < height; ++v) {
    const char* row = rest.data() + (height - 1 - v) * row_values * 4;  // rows go up
    for (std::size_t i = 0; i < row_values; ++i)
      image.samples[v * row_values + i] = load_float(row + 4 * i, scale < 0.0);
  }
  return image;
}

}  // namespace relief
