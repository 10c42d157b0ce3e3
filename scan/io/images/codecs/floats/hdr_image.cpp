// Radiance pictures: red, green and blue with a common exponent.
#include <charconv>
#include <cmath>
#include <vector>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/floats/hdr_header.h"
#include "scan/io/images/codecs/tiff_layout.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

constexpr std::string_view kRgbe = "32-bit_rle_rgbe";
// Two bytes make a run of 127 bytes. Only lines of these lengths have runs.
constexpr std::size_t kHdrRle = 64;
constexpr std::size_t kLeastPackedLine = 8, kMostPackedLine = 0x7fff;

// Why pixels cannot be read.
constexpr const char* kHdrTruncated = "truncated: its pixels end early; copy it again";
constexpr const char* kHdrLongRun = "damaged: a run goes beyond its line; copy it again";
constexpr const char* kHdrOldRuns =
    "unsupported runs of the first version of the format; save it again, or as .exr";

std::optional<std::string_view> take_hdr_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end + 1);
  return line;
}

// Takes `-Y 480` and a blank off.
bool take_hdr_axis(std::string_view& rest, char& sign, char& axis, std::size_t& size) {
  if (rest.size() < 4 || rest[2] != ' ') return false;
  sign = rest[0];
  axis = rest[1];
  const auto [end, error] = std::from_chars(rest.data() + 3, rest.data() + rest.size(), size);
  if (error != std::errc()) return false;
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  if (rest.starts_with(' ')) rest.remove_prefix(1);
  return (sign == '+' || sign == '-') && (axis == 'X' || axis == 'Y');
}

// Lines and pixels of a line in the direction of their numbers: y counts upwards, x to the right.
bool read_hdr_size(std::string_view line, HdrHeader& header) {
  char sign[2], axis[2];
  if (!take_hdr_axis(line, sign[0], axis[0], header.height) ||
      !take_hdr_axis(line, sign[1], axis[1], header.width) || !line.empty() || axis[0] == axis[1])
    return false;
  const bool columns = axis[0] == 'X';
  const bool from_right = sign[columns ? 0 : 1] == '-', from_bottom = sign[columns ? 1 : 0] == '+';
  const int corner = from_bottom ? (from_right ? 2 : 3) : (from_right ? 1 : 0);
  header.orientation = static_cast<std::uint16_t>(1 + corner + (columns ? 4 : 0));
  return true;
}

// Takes the pixels of one line after the other off the bytes of a picture.
class HdrLines {
 public:
  HdrLines(std::string_view bytes, std::size_t width) : rest_(bytes), width_(width) {}

  // A line of pixels of four bytes; false: why() tells it.
  bool take(std::vector<std::uint8_t>& line) { return is_packed() ? unpack(line) : copy(line); }
  const char* why() const { return why_; }

 private:
  std::uint8_t byte(std::size_t at) const { return static_cast<std::uint8_t>(rest_[at]); }
  bool fail(const char* why) {
    why_ = why;
    return false;
  }

  // Packed lines begin with a pixel that no other has, whose last bytes are the width.
  bool is_packed() const {
    return width_ >= kLeastPackedLine && width_ <= kMostPackedLine && rest_.size() >= 4 &&
           byte(0) == 2 && byte(1) == 2 && byte(2) < 128;
  }

  bool copy(std::vector<std::uint8_t>& line) {
    if (rest_.size() < line.size()) return fail(kHdrTruncated);
    for (std::size_t i = 0; i < line.size(); ++i) line[i] = byte(i);
    for (std::size_t i = 0; i < line.size(); i += 4)
      if (line[i] == 1 && line[i + 1] == 1 && line[i + 2] == 1) return fail(kHdrOldRuns);
    rest_.remove_prefix(line.size());
    return true;
  }

  bool unpack(std::vector<std::uint8_t>& line) {
    if (std::size_t{byte(2)} * 256 + byte(3) != width_)
      return fail("damaged: a line has another length than the picture; copy it again");
    rest_.remove_prefix(4);
    for (std::size_t c = 0; c < 4; ++c)
      if (!unpack_channel(line, c)) return false;
    return true;
  }

  // A count above 128 is that of a byte that repeats; others are those of bytes that follow.
  bool unpack_channel(std::vector<std::uint8_t>& line, std::size_t channel) {
    for (std::size_t u = 0; u < width_;) {
      const std::size_t head = rest_.empty() ? 0 : byte(0);
      const bool repeats = head > 128;
      const std::size_t count = repeats ? head - 128 : head, stored = repeats ? 1 : count;
      if (rest_.size() < 1 + stored) return fail(kHdrTruncated);
      if (count == 0 || count > width_ - u) return fail(kHdrLongRun);
      for (std::size_t i = 0; i < count; ++i, ++u)
        line[4 * u + channel] = byte(repeats ? 1 : 1 + i);
      rest_.remove_prefix(1 + stored);
    }
    return true;
  }

  std::string_view rest_;
  std::size_t width_ = 0;
  const char* why_ = "";
};

Result<Image> read_hdr_pixels(const HdrHeader& header, std::string_view bytes,
                              const std::filesystem::path& path) {
  constexpr int kOneByExponent = 128 + 8;  // Mantissas are whole numbers of 8 bits.
  Image image(static_cast<int>(header.width), static_cast<int>(header.height), 3);
  std::vector<std::uint8_t> line(4 * header.width);
  HdrLines lines(bytes, header.width);
  float* sample = image.samples.data();
  for (std::size_t v = 0; v < header.height; ++v) {
    if (!lines.take(line)) return bad_input(path, lines.why());
    for (std::size_t i = 0; i < line.size(); i += 4)
      for (std::size_t c = 0; c < 3; ++c)
        *sample++ = line[i + 3] == 0
                        ? 0.0f
                        : std::ldexp(static_cast<float>(line[i + c]), line[i + 3] - kOneByExponent);
  }
  return image;
}

}  // namespace

std::optional<HdrHeader> read_hdr_header(std::string_view content) {
  constexpr std::string_view kFormat = "FORMAT=";
  if (!content.starts_with("#?")) return std::nullopt;
  HdrHeader header;
  std::string_view rest = content;
  auto line = take_hdr_line(rest);
  for (; line && !line->empty(); line = take_hdr_line(rest))
    if (line->starts_with(kFormat)) header.format = line->substr(kFormat.size());
  if (line) line = take_hdr_line(rest);
  if (!line || !read_hdr_size(*line, header)) return std::nullopt;
  header.pixels_at = content.size() - rest.size();
  return header;
}

Result<Image> decode_hdr(std::string_view content, const std::filesystem::path& path) {
  const auto header = read_hdr_header(content);
  if (!header)
    return bad_input(path,
                     "not a Radiance picture, or one that ends within its header: '#?RADIANCE', "
                     "an empty line and '-Y HEIGHT +X WIDTH' expected");
  if (!header->format.empty() && header->format != kRgbe)
    return bad_input(path, "unsupported format '" + header->format + "'; save it as " +
                               std::string(kRgbe) + ", or as .exr");
  ImageHeader bounds{header->width, header->height, 32, 3};
  if (header->width >= kLeastPackedLine && header->width <= kMostPackedLine)
    bounds.compression = kHdrRle;
  if (auto checked = check_image_header(bounds, content.size() - header->pixels_at, path); !checked)
    return checked.error();
  auto image = read_hdr_pixels(*header, content.substr(header->pixels_at), path);
  if (!image) return image;
  return upright(*std::move(image), header->orientation);
}

}  // namespace relief
