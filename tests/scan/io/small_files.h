#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scan/io/files/binary_writer.h"

namespace relief::testing {

/// The head of a PNG of `width` x 4 pixels, which is all that is looked at before a view is read.
inline std::string png_head(unsigned char width) {
  std::string head("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0", 19);
  return head + static_cast<char>(width) + std::string("\0\0\0\x04", 4);
}

/// A NumPy file with the text of its header.
inline std::string npy_file(const std::string& dictionary, const std::string& numbers,
                            int version = 1) {
  std::string file("\x93NUMPY", 6);
  file += {static_cast<char>(version), '\0'};
  if (version == 1)
    append_little_endian(file, static_cast<std::uint16_t>(dictionary.size()));
  else
    append_little_endian(file, static_cast<std::uint32_t>(dictionary.size()));
  return file + dictionary + numbers;
}

inline std::string npy_array(const std::string& type, const std::string& shape,
                             const std::string& numbers, bool columns_first = false) {
  return npy_file("{'descr': '" + type + "', 'fortran_order': " +
                      (columns_first ? "True" : "False") + ", 'shape': " + shape + ", }      \n",
                  numbers);
}

/// An array of doubles.
inline std::string npy_array(const std::string& shape, const std::vector<double>& numbers,
                             bool columns_first = false) {
  std::string bytes;
  for (const double number : numbers) append_little_endian(bytes, number);
  return npy_array("<f8", shape, bytes, columns_first);
}

}  // namespace relief::testing
