// The one file that meets libjpeg.
#include <csetjmp>
#include <cstdio>
#include <vector>

#include <jpeglib.h>

#include "scan/io/files/io_error.h"
#include "scan/io/images/image_io.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

// A progressive file spends at least a bit on each block of 64 samples; colours at half resolution
// make twice as many samples of a block.
constexpr std::size_t kJpegBlocks = 1024;

// libjpeg reports errors by a function that must not return: here it jumps. The functions below
// that call setjmp hold plain data only.
struct JpegErrors {
  jpeg_error_mgr base;  // First: libjpeg hands a pointer to it back.
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX];
};

void fail_jpeg(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  jpeg->err->format_message(jpeg, errors->message);
  std::longjmp(errors->jump, 1);
}

// Warnings stand for damaged data, which libjpeg would replace by grey.
void on_jpeg_message(j_common_ptr jpeg, int level) {
  if (level < 0) fail_jpeg(jpeg);
}

bool read_jpeg_header(jpeg_decompress_struct& jpeg, JpegErrors& errors, const char* data,
                      std::size_t size) {
  if (setjmp(errors.jump)) return false;
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(data), size);
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = jpeg.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  return true;
}

bool read_jpeg_rows(jpeg_decompress_struct& jpeg, JpegErrors& errors, unsigned char* bytes) {
  if (setjmp(errors.jump)) return false;
  jpeg_start_decompress(&jpeg);
  const std::size_t row_bytes = static_cast<std::size_t>(jpeg.output_width) *
                                static_cast<std::size_t>(jpeg.output_components);
  while (jpeg.output_scanline < jpeg.output_height) {
    unsigned char* row = bytes + row_bytes * jpeg.output_scanline;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  return true;
}

class JpegReader {
 public:
  explicit JpegReader(std::string_view content) : content_(content) {
    jpeg_.err = jpeg_std_error(&errors_.base);
    errors_.base.error_exit = fail_jpeg;
    errors_.base.emit_message = on_jpeg_message;
    errors_.message[0] = '\0';
  }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() { jpeg_destroy_decompress(&jpeg_); }

  Result<Image> read(const std::filesystem::path& path) {
    if (!read_jpeg_header(jpeg_, errors_, content_.data(), content_.size())) return damaged(path);
    if (jpeg_.num_components != 1 && jpeg_.num_components != 3)
      return bad_input(path, "a JPEG of " + std::to_string(jpeg_.num_components) +
                                 " channels (CMYK?); save it as grey or RGB");
    const std::size_t width = jpeg_.image_width, height = jpeg_.image_height;
    const auto channels = static_cast<std::size_t>(jpeg_.num_components);
    if (auto checked = check_image_header({width, height, 8 * channels, channels, kJpegBlocks},
                                          content_.size(), path);
        !checked)
      return checked.error();
    std::vector<unsigned char> bytes(width * height * channels);
    if (!read_jpeg_rows(jpeg_, errors_, bytes.data())) return damaged(path);
    Image image(static_cast<int>(width), static_cast<int>(height), static_cast<int>(channels), 255);
    image.samples.assign(bytes.begin(), bytes.end());
    return image;
  }

 private:
  Error damaged(const std::filesystem::path& path) const {
    return bad_input(path, std::string("damaged JPEG: ") + errors_.message);
  }

  std::string_view content_;
  jpeg_decompress_struct jpeg_{};
  JpegErrors errors_{};
};

}  // namespace

Result<Image> decode_jpeg(std::string_view content, const std::filesystem::path& path) {
  return JpegReader(content).read(path);
}

}  // namespace relief
