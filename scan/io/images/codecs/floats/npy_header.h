#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "relief/scan/result.h"

namespace relief {

/// What the header of a NumPy file says.
struct NpyHeader {
  char order = '|';  ///< `<`, `>`, or `|` for single bytes.
  char kind = 'f';   ///< `f`, `i`, `u`, or `b` for truth values.
  std::size_t bytes = 4;
  bool columns_first = false;      ///< `fortran_order`.
  std::vector<std::size_t> shape;  ///< As given, of any length.
  std::size_t numbers_at = 0;      ///< [bytes]
};

/// The shape of an array as an image, (rows, columns) or (rows, columns, channels): without leading
/// axes of length 1, as of a batch of one image. Other shapes as they are.
std::vector<std::size_t> image_shape(const NpyHeader& header);

/// Parses the header of a .npy file of version 1.0 to 3.0. kBadInput with the byte that is wrong.
Result<NpyHeader> read_npy_header(std::string_view content, const std::filesystem::path& path);

/// The floats behind a header by rows, at most as many as its shape says. None of other types, of
/// another order of bytes, and of arrays of three and more dimensions that are stored by columns.
std::vector<double> read_npy_floats(std::string_view content, const NpyHeader& header);

}  // namespace relief
