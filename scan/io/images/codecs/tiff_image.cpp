#include <algorithm>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>

#include <Eigen/Core>
#include <tiffio.h>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/tiff_layout.h"
#include "scan/io/images/image_io.h"

namespace relief {

namespace {

// A file in memory, as libtiff's client callbacks want it, and the first error reported on it.
struct MemoryFile {
  std::string_view input;
  std::string* output = nullptr;  // null: read only
  std::size_t position = 0;
  std::string message;

  std::size_t size() const { return output ? output->size() : input.size(); }
};

MemoryFile& file_of(thandle_t handle) { return *static_cast<MemoryFile*>(handle); }

tmsize_t on_read(thandle_t handle, void* data, tmsize_t length) {
  MemoryFile& file = file_of(handle);
  const char* bytes = file.output ? file.output->data() : file.input.data();
  const std::size_t left = file.size() - std::min(file.size(), file.position);
  const std::size_t count = std::min(left, static_cast<std::size_t>(std::max<tmsize_t>(length, 0)));
  std::memcpy(data, bytes + file.position, count);
  file.position += count;
  return static_cast<tmsize_t>(count);
}

tmsize_t on_write(thandle_t handle, void* data, tmsize_t length) {
  MemoryFile& file = file_of(handle);
  if (!file.output || length < 0) return -1;
  const auto count = static_cast<std::size_t>(length);
  if (file.output->size() < file.position + count) file.output->resize(file.position + count);
  std::memcpy(file.output->data() + file.position, data, count);
  file.position += count;
  return length;
}

toff_t on_seek(thandle_t handle, toff_t offset, int whence) {
  MemoryFile& file = file_of(handle);
  if (whence == SEEK_CUR) offset += file.position;
  if (whence == SEEK_END) offset += file.size();
  return file.position = static_cast<std::size_t>(offset);
}

int on_close(thandle_t) { return 0; }
toff_t on_size(thandle_t handle) { return file_of(handle).size(); }

int on_error(TIFF*, void* user, const char* module, const char* format, va_list arguments) {
  auto* file = static_cast<MemoryFile*>(user);
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  if (file->message.empty()) file->message = std::string(module ? module : "TIFF") + ": " + text;
  return 1;
}

int on_warning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

using TiffHandle = std::unique_ptr<TIFF, void (*)(TIFF*)>;

TiffHandle open_tiff(MemoryFile& file, const char* mode) {
  const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                             TIFFOpenOptionsFree);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), on_error, &file);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), on_warning, nullptr);
  return TiffHandle(TIFFClientOpenExt("", mode, &file, on_read, on_write, on_seek, on_close,
                                      on_size, nullptr, nullptr, options.get()),
                    [](TIFF* tiff) {
                      if (tiff) TIFFClose(tiff);
                    });
}

template <typename T>
T load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

float sample_value(const TiffLayout& layout, const std::uint8_t* bytes) {
  if (layout.format == SAMPLEFORMAT_UINT)
    return layout.bits == 8 ? *bytes : load<std::uint16_t>(bytes);
  if (layout.bits == 16) return static_cast<float>(load<Eigen::half>(bytes));
  if (layout.bits == 32) return load<float>(bytes);
  return static_cast<float>(load<double>(bytes));
}

// Copies a block of decoded samples, whose top left pixel is (u0,v0), into the image. `plane` is
// the channel that a block of separate planes holds.
void copy_block(const TiffLayout& layout, const std::uint8_t* block, std::size_t block_width,
                std::size_t rows, int u0, int v0, int plane, Image& image) {
  const int in_block = layout.separate() ? 1 : layout.samples_per_pixel;
  const std::size_t row_bytes =
      block_width * static_cast<std::size_t>(in_block) * layout.sample_bytes();
  const int columns = std::min(static_cast<int>(block_width), image.width - u0);
  for (std::size_t row = 0; row < rows && v0 + static_cast<int>(row) < image.height; ++row) {
    for (int column = 0; column < columns; ++column) {
      for (int channel = 0; channel < in_block; ++channel) {
        const int target = layout.separate() ? plane : channel;
        if (target >= image.channels) continue;
        const std::size_t offset = static_cast<std::size_t>(column * in_block + channel);
        image(u0 + column, v0 + static_cast<int>(row), target) =
            sample_value(layout, block + row * row_bytes + offset * layout.sample_bytes());
      }
    }
  }
}

bool read_rows(TIFF* tiff, const TiffLayout& layout, Image& image) {
  std::vector<std::uint8_t> row(static_cast<std::size_t>(TIFFScanlineSize64(tiff)));
  const std::size_t in_block = layout.separate() ? 1 : layout.samples_per_pixel;
  if (row.size() < layout.width * in_block * layout.sample_bytes()) return false;
  for (int plane = 0; plane < (layout.separate() ? image.channels : 1); ++plane) {
    for (std::uint32_t v = 0; v < layout.height; ++v) {
      if (TIFFReadScanline(tiff, row.data(), v, static_cast<std::uint16_t>(plane)) != 1)
        return false;
      copy_block(layout, row.data(), layout.width, 1, 0, static_cast<int>(v), plane, image);
    }
  }
  return true;
}

bool read_tiles(TIFF* tiff, const TiffLayout& layout, std::size_t file_bytes, Image& image) {
  std::uint32_t tile_width = 0, tile_height = 0;
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_width);
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &tile_height);
  const std::size_t in_block = layout.separate() ? 1 : layout.samples_per_pixel;
  const std::size_t pixel_bytes = in_block * layout.sample_bytes();
  TiffLayout one_tile = layout;
  one_tile.width = tile_width;
  one_tile.height = tile_height;
  if (!check_tiff_layout(one_tile, file_bytes, "")) return false;
  std::vector<std::uint8_t> tile(static_cast<std::size_t>(TIFFTileSize64(tiff)));
  if (tile.size() < tile_width * pixel_bytes * tile_height) return false;
  for (int plane = 0; plane < (layout.separate() ? image.channels : 1); ++plane) {
    for (std::uint32_t v = 0; v < layout.height; v += tile_height) {
      for (std::uint32_t u = 0; u < layout.width; u += tile_width) {
        if (TIFFReadTile(tiff, tile.data(), u, v, 0, static_cast<std::uint16_t>(plane)) < 0)
          return false;
        copy_block(layout, tile.data(), tile_width, tile_height, static_cast<int>(u),
                   static_cast<int>(v), plane, image);
      }
    }
  }
  return true;
}

bool write_rows(TIFF* tiff, const Image& image) {
  const auto width = static_cast<std::uint32_t>(image.width);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(image.height));
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, image.channels);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 32);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
               image.channels == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(tiff, TIFFTAG_PREDICTOR, PREDICTOR_FLOATINGPOINT);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff, 0));
  // The predictor works in place: libtiff gets a copy of each row.
  std::vector<float> row(static_cast<std::size_t>(image.width * image.channels));
  for (int v = 0; v < image.height; ++v) {
    std::copy_n(image.samples.begin() + static_cast<std::ptrdiff_t>(image.index(0, v)), row.size(),
                row.begin());
    if (TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(v), 0) != 1) return false;
  }
  return TIFFWriteDirectory(tiff) == 1;
}

}  // namespace

Result<Image> decode_tiff(std::string_view content, const std::filesystem::path& path) {
  MemoryFile file;
  file.input = content;
  const TiffHandle tiff = open_tiff(file, "rm");
  if (!tiff) return bad_input(path, "not a readable TIFF: " + file.message);
  const TiffLayout layout = read_tiff_layout(tiff.get());
  if (auto checked = check_tiff_layout(layout, content.size(), path); !checked)
    return checked.error();
  const double max_value =
      layout.format == SAMPLEFORMAT_IEEEFP ? 0.0 : (layout.bits == 8 ? 255.0 : 65535.0);
  Image image(static_cast<int>(layout.width), static_cast<int>(layout.height), layout.channels(),
              max_value);
  const bool read = TIFFIsTiled(tiff.get()) ? read_tiles(tiff.get(), layout, content.size(), image)
                                            : read_rows(tiff.get(), layout, image);
  if (!read)
    return bad_input(path, "damaged or truncated TIFF" +
                               (file.message.empty() ? std::string() : ": " + file.message));
  if (layout.photometric == PHOTOMETRIC_MINISWHITE)
    for (float& sample : image.samples) sample = static_cast<float>(max_value) - sample;
  return upright(std::move(image), layout.orientation);
}

Result<std::string> encode_tiff(const Image& image) {
  std::string encoded;
  MemoryFile file;
  file.output = &encoded;
  TiffHandle tiff = open_tiff(file, "wm");
  const bool written = tiff && write_rows(tiff.get(), image);
  tiff.reset();
  if (!written) return Error{ErrorKind::kCannotWrite, "TIFF: " + file.message};
  return encoded;
}

}  // namespace relief
