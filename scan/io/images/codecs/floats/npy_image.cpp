// NumPy arrays as images.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/floats/npy_header.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

bool is_readable_type(const NpyHeader& header) {
  if (header.order == '|' && header.bytes != 1) return false;
  switch (header.kind) {
    case 'f':
      return header.bytes == 2 || header.bytes == 4 || header.bytes == 8;
    case 'i':
    case 'u':
      return header.bytes == 1 || header.bytes == 2 || header.bytes == 4 || header.bytes == 8;
    case 'b':
      return header.bytes == 1;
    default:
      return false;
  }
}

std::string shape_text(const NpyHeader& header) {
  std::string text = "(";
  for (const std::size_t size : header.shape) text += std::to_string(size) + ",";
  return text + ")";
}

Result<void> check_npy(const NpyHeader& header, std::size_t file_bytes,
                       const std::filesystem::path& path) {
  if (!is_readable_type(header))
    return bad_input(path, std::string("numbers of type '") + header.order + header.kind +
                               std::to_string(header.bytes) +
                               "'; u1 u2 u4 u8 i1 i2 i4 i8 f2 f4 f8 and b1 are read: save "
                               "array.astype('f4')");
  const std::vector<std::size_t> shape = image_shape(header);
  if (shape.size() < 2 || shape.size() > 3 || (shape.size() == 3 && shape[2] != 1 && shape[2] != 3))
    return bad_input(path, "its shape is " + shape_text(header) +
                               "; an image has (rows, columns), with 1 or 3 channels behind; "
                               "channels in front go behind by numpy.moveaxis(array, 0, -1)");
  const std::size_t channels = shape.size() == 3 ? shape[2] : 1;
  const ImageHeader image{shape[1], shape[0], 8 * header.bytes * channels, channels};
  if (auto checked = check_image_header(image, file_bytes, path); !checked) return checked;
  const std::size_t bytes = shape[0] * shape[1] * channels * header.bytes;
  if (file_bytes - header.numbers_at != bytes)
    return bad_input(path, "its shape " + shape_text(header) + " takes " + std::to_string(bytes) +
                               " bytes, " + std::to_string(file_bytes - header.numbers_at) +
                               " follow the header; it is damaged: save it again");
  return {};
}

// A number in the machine's order of bytes.
template <typename T>
float npy_number(const char* bytes, bool big) {
  std::array<char, sizeof(T)> raw;
  std::copy_n(bytes, sizeof(T), raw.begin());
  if (big != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
  T value;
  std::memcpy(&value, raw.data(), sizeof(T));
  return static_cast<float>(value);
}

using NumberReader = float (*)(const char* bytes, bool big);

NumberReader npy_reader(const NpyHeader& header) {
  const bool is_signed = header.kind == 'i';
  if (header.kind == 'f')
    return header.bytes == 2   ? npy_number<Eigen::half>
           : header.bytes == 4 ? npy_number<float>
                               : npy_number<double>;
  if (header.bytes == 1) return is_signed ? npy_number<std::int8_t> : npy_number<std::uint8_t>;
  if (header.bytes == 2) return is_signed ? npy_number<std::int16_t> : npy_number<std::uint16_t>;
  if (header.bytes == 4) return is_signed ? npy_number<std::int32_t> : npy_number<std::uint32_t>;
  return is_signed ? npy_number<std::int64_t> : npy_number<std::uint64_t>;
}

// Only unsigned integers of 8 and 16 bits have a largest value, as in other images.
double npy_max_value(const NpyHeader& header) {
  if (header.kind != 'u' || header.bytes > 2) return 0.0;
  return header.bytes == 1 ? 255.0 : 65535.0;
}

}  // namespace

Result<Image> decode_npy(std::string_view content, const std::filesystem::path& path) {
  const auto header = read_npy_header(content, path);
  if (!header) return header.error();
  if (auto checked = check_npy(*header, content.size(), path); !checked) return checked.error();
  const std::vector<std::size_t> shape = image_shape(*header);
  const std::size_t height = shape[0], width = shape[1];
  const std::size_t channels = shape.size() == 3 ? shape[2] : 1;
  Image image(static_cast<int>(width), static_cast<int>(height), static_cast<int>(channels),
              npy_max_value(*header));
  const NumberReader number = npy_reader(*header);
  const char* numbers = content.data() + header->numbers_at;
  float* sample = image.samples.data();
  for (std::size_t v = 0; v < height; ++v) {
    for (std::size_t u = 0; u < width; ++u) {
      for (std::size_t c = 0; c < channels; ++c) {
        const std::size_t place =
            header->columns_first ? v + height * (u + width * c) : (v * width + u) * channels + c;
        *sample++ = number(numbers + place * header->bytes, header->order == '>');
      }
    }
  }
  return image;
}

}  // namespace relief
