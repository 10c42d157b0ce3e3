#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "relief/scan/result.h"

namespace relief {

/// What the header of a PCD file says of the data that follow.
struct PcdHeader {
  enum class Data { kAscii, kBinary, kCompressed };

  std::size_t width = 0, height = 0;  ///< Places of the grid; `height` 1: not organized.
  bool sized_by_points = false;       ///< WIDTH and HEIGHT are 0 in the file; POINTS tells them.
  std::size_t points = 0;
  std::size_t fields = 0;
  bool has_position = false;  ///< There is a field x: PCL also writes files of normals alone.
  std::size_t values_per_point = 0;  ///< Numbers of a point in an ASCII file.
  std::size_t point_bytes = 0;       ///< Of a point in memory and in a binary file.
  Data data = Data::kAscii;
  std::size_t data_start = 0;     ///< Where the data begin [bytes].
  std::vector<double> viewpoint;  ///< Its seven numbers; empty: none, or the identity.
  bool ends_in_return = false;    ///< Lines end in a carriage return alone, as on classic Macs.
};

/// Reads the header and holds what it promises against the size of the file, before anything is
/// allocated for it. A file may hold no more points than its bytes allow: two bytes a number in
/// ASCII, and a hundredth of the promised bytes where they are compressed (LZF copies at most 264
/// bytes for three). Lines end as those of read_line(). Unless `organized`, a file of one row is
/// read as well, of any width. Errors (kBadInput) name the file and the line.
Result<PcdHeader> read_pcd_header(const std::filesystem::path& path, bool organized = true);

}  // namespace relief
