#include <algorithm>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include <png.h>

#include "scan/io/files/io_error.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

// libpng reports errors by longjmp, which must not cross C++ objects with destructors. Every
// function below that calls setjmp therefore handles plain pointers only; buffers and strings live
// in its callers.
struct PngState {
  const char* input = nullptr;
  std::size_t input_left = 0;
  std::string* output = nullptr;
  char message[256] = "";
};

void on_error(png_structp png, png_const_charp message) {
  auto* state = static_cast<PngState*>(png_get_error_ptr(png));
  std::snprintf(state->message, sizeof state->message, "%s", message);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep data, png_size_t length) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  if (length > state->input_left) png_error(png, "the file is truncated");
  std::memcpy(data, state->input, length);
  state->input += length;
  state->input_left -= length;
}

void on_write(png_structp png, png_bytep data, png_size_t length) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  state->output->append(reinterpret_cast<const char*>(data), length);
}

void on_flush(png_structp) {}

// Samples become 8 or 16 bits (in the machine's byte order), grey or RGB.
bool read_header(png_structp png, png_infop info, std::size_t& pixel_bits) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_read_info(png, info);
  pixel_bits = std::size_t{png_get_bit_depth(png, info)} * png_get_channels(png, info);
  const int colour = png_get_color_type(png, info);
  if (colour == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (colour == PNG_COLOR_TYPE_GRAY && png_get_bit_depth(png, info) < 8)
    png_set_expand_gray_1_2_4_to_8(png);
  png_set_strip_alpha(png);
  if (png_get_bit_depth(png, info) == 16) png_set_swap(png);
  (void)png_set_interlace_handling(png);
  png_read_update_info(png, info);
  return true;
}

bool read_rows(png_structp png, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

int colour_type(int channels) {
  if (channels == 4) return PNG_COLOR_TYPE_RGB_ALPHA;
  return channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY;
}

bool write_rows(png_structp png, png_infop info, const Image& image, png_textp texts,
                int text_count, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png))) return false;
  const int depth = image.max_value > 255.0 ? 16 : 8;
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height), depth, colour_type(image.channels),
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (text_count > 0) png_set_text(png, info, texts, text_count);
  png_write_info(png, info);
  if (depth == 16) png_set_swap(png);
  png_write_image(png, rows);
  png_write_end(png, info);
  return true;
}

std::vector<png_bytep> row_pointers(std::vector<png_byte>& bytes, std::size_t rows) {
  std::vector<png_bytep> pointers(rows);
  for (std::size_t v = 0; v < rows; ++v) pointers[v] = bytes.data() + v * (bytes.size() / rows);
  return pointers;
}

// libpng's view of `texts`, which must outlive it. libpng does not change what it points to.
std::vector<png_text> text_pointers(const std::vector<PngText>& texts) {
  std::vector<png_text> pointers;
  for (const PngText& text : texts) {
    png_text pointer{};
    pointer.compression = PNG_ITXT_COMPRESSION_NONE;
    pointer.key = const_cast<char*>(text.keyword.c_str());
    pointer.text = const_cast<char*>(text.text.c_str());
    pointers.push_back(pointer);
  }
  return pointers;
}

// Owns libpng's structures.
class PngReader {
 public:
  explicit PngReader(std::string_view content) {
    state_.input = content.data();
    state_.input_left = content.size();
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &state_, on_error, on_warning);
    if (png_) info_ = png_create_info_struct(png_);
    if (info_) png_set_read_fn(png_, &state_, on_read);
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  Result<Image> read(std::size_t file_bytes, const std::filesystem::path& path) {
    if (!info_) return bad_input(path, "out of memory");
    if (!read_header(png_, info_, pixel_bits_)) return damaged(path);
    const std::size_t width = png_get_image_width(png_, info_);
    const std::size_t height = png_get_image_height(png_, info_);
    const int channels = png_get_channels(png_, info_);
    const bool wide = png_get_bit_depth(png_, info_) == 16;
    const std::size_t row_bytes = png_get_rowbytes(png_, info_);
    if (auto checked = check_image_header(
            {width, height, pixel_bits_, static_cast<std::size_t>(channels), kDeflate}, file_bytes,
            path);
        !checked)
      return checked.error();
    std::vector<png_byte> bytes(row_bytes * height);
    if (!read_rows(png_, row_pointers(bytes, height).data())) return damaged(path);

    Image image(static_cast<int>(width), static_cast<int>(height), channels, wide ? 65535 : 255);
    for (std::size_t i = 0; i < image.samples.size(); ++i) {
      std::uint16_t value = bytes[i];
      if (wide) std::memcpy(&value, bytes.data() + 2 * i, 2);
      image.samples[i] = value;
    }
    return image;
  }

 private:
  Error damaged(const std::filesystem::path& path) const {
    return bad_input(path, std::string("damaged PNG: ") + state_.message);
  }

  PngState state_;
  std::size_t pixel_bits_ = 0;  // In the file.
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

std::vector<png_byte> integer_samples(const Image& image) {
  const bool wide = image.max_value > 255.0;
  std::vector<png_byte> bytes(image.samples.size() * (wide ? 2 : 1));
  for (std::size_t i = 0; i < image.samples.size(); ++i) {
    const double sample = image.samples[i] > 0.0f ? image.samples[i] : 0.0;  // NaN becomes 0
    const auto value = static_cast<std::uint16_t>(std::min(sample, image.max_value) + 0.5);
    if (wide)
      std::memcpy(bytes.data() + 2 * i, &value, 2);
    else
      bytes[i] = static_cast<png_byte>(value);
  }
  return bytes;
}

}  // namespace

Result<Image> decode_png(std::string_view content, const std::filesystem::path& path) {
  if (content.size() < 8 ||
      png_sig_cmp(reinterpret_cast<png_const_bytep>(content.data()), 0, 8) != 0)
    return bad_input(path, "not a PNG file");
  return PngReader(content).read(content.size(), path);
}

Result<std::string> encode_png(const Image& image, const std::vector<PngText>& texts) {
  std::string encoded;
  PngState state;
  state.output = &encoded;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &state, on_error, on_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  std::vector<png_byte> bytes = integer_samples(image);
  std::vector<png_bytep> rows = row_pointers(bytes, static_cast<std::size_t>(image.height));
  if (info) png_set_write_fn(png, &state, on_write, on_flush);
  std::vector<png_text> remarks = text_pointers(texts);
  const bool written = info && write_rows(png, info, image, remarks.data(),
                                          static_cast<int>(remarks.size()), rows.data());
  png_destroy_write_struct(&png, &info);
  if (!written) return Error{ErrorKind::kCannotWrite, std::string("PNG: ") + state.message};
  return encoded;
}

}  // namespace relief
