#include "scan/io/images/codecs/floats/exr_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>

#include "scan/io/files/io_error.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kMultiPart = 0x1000;
// What may be unpacked at once whatever the size of the image.
constexpr std::size_t kAlwaysAllowed = std::size_t{64} << 20;
// An entry in the table of offsets, and the place and size before the data of a chunk [bytes].
constexpr std::size_t kChunkBytes = 16;

// By the number of the compression in the file.
struct Compression {
  std::size_t lines;  // Scan lines that are packed together.
  std::size_t most;   // Bytes in one, at most.
};
constexpr std::array<Compression, 10> kCompressions{{
    {1, kUncompressed},
    {1, 64},                  // RLE: 128 bytes in two
    {1, kDeflate},            // ZIPS
    {16, kDeflate},           // ZIP
    {32, 512},                // PIZ: Huffman codes of runs of up to 255 values
    {16, kDeflate * 4 / 3},   // PXR24: three bytes of four are deflated
    {32, 11},                 // B44: 32 bytes in three
    {32, 11},                 // B44A
    {32, kDeflate * 64 * 2},  // DWAA: one value for 64 of a block, deflated, of half the bytes
    {256, kDeflate * 64 * 2}  // DWAB
}};

// One header, as far as it tells what is allocated.
struct Part {
  std::int64_t width = 0, height = 0;
  std::size_t pixel_bytes = 0, channels = 0;
  std::optional<std::size_t> compression;
  std::size_t tile_width = 0, tile_height = 0;  // 0: in scan lines.
  std::size_t chunks = 0;                       // As promised; 0: not said.
};

std::size_t divided_up(std::size_t a, std::size_t b) { return (a + b - 1) / b; }

class ExrHeaders {
 public:
  ExrHeaders(std::string_view content, const std::filesystem::path& path)
      : path_(path), rest_(content), file_bytes_(content.size()) {}

  Result<void> check() {
    const auto magic = take<std::uint32_t>(), version = take<std::uint32_t>();
    if (!magic || !version || *magic != kMagic) return bad_input(path_, "not an OpenEXR file");
    const bool multi_part = (*version & kMultiPart) != 0;
    do {
      Part part;
      if (auto read = read_part(part); !read) return read;
      if (auto checked = check_part(part); !checked) return checked;
    } while (multi_part && !rest_.empty() && rest_.front() != '\0');
    return {};
  }

 private:
  Error truncated() const {
    return bad_input(path_, "damaged or truncated OpenEXR header, byte " +
                                std::to_string(file_bytes_ - rest_.size()));
  }

  template <typename T>
  static T load(std::string_view bytes) {  // OpenEXR is little endian, as is x86-64.
    T value;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }

  template <typename T>
  std::optional<T> take() {
    if (rest_.size() < sizeof(T)) return std::nullopt;
    const T value = load<T>(rest_);
    rest_.remove_prefix(sizeof(T));
    return value;
  }

  static std::optional<std::string_view> take_name(std::string_view& bytes) {
    const std::size_t end = bytes.find('\0');
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view name = bytes.substr(0, end);
    bytes.remove_prefix(end + 1);
    return name;
  }

  Result<void> read_part(Part& part) {
    for (;;) {
      const auto name = take_name(rest_);
      if (!name) return truncated();
      if (name->empty()) return {};
      const auto type = take_name(rest_);
      const auto size = take<std::int32_t>();
      if (!type || !size || *size < 0 || static_cast<std::size_t>(*size) > rest_.size())
        return truncated();
      const std::string_view value = rest_.substr(0, static_cast<std::size_t>(*size));
      if (!read_attribute(*name, *type, value, part)) return truncated();
      rest_.remove_prefix(value.size());
    }
  }

  static bool read_attribute(std::string_view name, std::string_view type, std::string_view value,
                             Part& part) {
    if (type == "preview")
      return value.size() >= 8 &&
             (value.size() - 8) / 4 ==
                 std::size_t{load<std::uint32_t>(value)} * load<std::uint32_t>(value.substr(4));
    if (name == "channels") return read_channels(value, part);
    if (name == "compression") {
      if (value.size() != 1) return false;
      part.compression = static_cast<unsigned char>(value.front());
    } else if (name == "dataWindow") {
      if (value.size() != 16) return false;
      std::array<std::int32_t, 4> window{};
      std::memcpy(window.data(), value.data(), 16);
      part.width = std::int64_t{window[2]} - window[0] + 1;
      part.height = std::int64_t{window[3]} - window[1] + 1;
    } else if (name == "tiles") {
      if (value.size() != 9) return false;
      part.tile_width = load<std::uint32_t>(value);
      part.tile_height = load<std::uint32_t>(value.substr(4));
      return part.tile_width > 0 && part.tile_height > 0;
    } else if (name == "chunkCount") {
      if (value.size() != 4 || load<std::int32_t>(value) < 0) return false;
      part.chunks = static_cast<std::size_t>(load<std::int32_t>(value));
    }
    return true;
  }

  // Each: a name, the type, a flag, three bytes of nothing, the sampling along x and y.
  static bool read_channels(std::string_view value, Part& part) {
    constexpr std::size_t kDescription = 16;
    constexpr std::int32_t kHalf = 1;
    for (;;) {
      const auto name = take_name(value);
      if (!name) return false;
      if (name->empty()) return true;
      if (value.size() < kDescription) return false;
      part.pixel_bytes += load<std::int32_t>(value) == kHalf ? 2 : 4;
      ++part.channels;
      value.remove_prefix(kDescription);
    }
  }

  Result<void> check_part(const Part& part) const {
    if (!part.compression || *part.compression >= kCompressions.size() || part.channels == 0)
      return bad_input(path_,
                       "damaged or unsupported OpenEXR: it names no channels or no compression "
                       "known here; save it with the compression ZIP");
    const Compression& compression = kCompressions[*part.compression];
    ImageHeader header;
    header.width = static_cast<std::size_t>(std::max<std::int64_t>(part.width, 0));
    header.height = static_cast<std::size_t>(std::max<std::int64_t>(part.height, 0));
    header.pixel_bits = 8 * part.pixel_bytes;
    header.channels = std::min<std::size_t>(part.channels, 3);
    header.compression = compression.most;
    if (auto checked = check_image_header(header, file_bytes_, path_); !checked) return checked;
    return check_chunks(part, header, compression);
  }

  Result<void> check_chunks(const Part& part, const ImageHeader& image,
                            const Compression& compression) const {
    const bool tiled = part.tile_width > 0;
    const std::size_t width = tiled ? std::max(part.tile_width, image.width) : image.width;
    const std::size_t lines = tiled ? part.tile_height : compression.lines;
    const std::size_t across = tiled ? divided_up(image.width, part.tile_width) : 1;
    const std::size_t chunks = std::max(part.chunks, across * divided_up(image.height, lines));
    if (chunks > file_bytes_ / kChunkBytes)
      return bad_input(path_, "the header promises " + std::to_string(chunks) +
                                  " blocks of pixels, more than a file of " +
                                  std::to_string(file_bytes_) + " bytes can hold; it is truncated");
    const std::size_t whole = image.width * image.height * part.pixel_bytes;
    const std::size_t allowed = std::max(kAlwaysAllowed, whole);
    if (lines > allowed / width / part.pixel_bytes)
      return bad_input(path_, "the header says that pixels are packed in blocks of " +
                                  std::to_string(width) + "x" + std::to_string(lines) +
                                  ", far larger than the image; save it in scan lines");
    return {};
  }

  const std::filesystem::path& path_;
  std::string_view rest_;
  std::size_t file_bytes_;
};

}  // namespace

Result<void> check_exr_headers(std::string_view content, const std::filesystem::path& path) {
  return ExrHeaders(content, path).check();
}

}  // namespace relief
