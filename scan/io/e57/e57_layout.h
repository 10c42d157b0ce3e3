#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "scan/io/e57/e57_pages.h"

namespace relief {

/// Least and greatest value of something.
struct E57Limits {
  double low = 0.0, high = 0.0;
};

/// One field of the records of a scan: one bytestream of its packets.
struct E57Field {
  enum class Type { kFloat, kDouble, kInteger, kText };

  std::string name;  ///< As in the standard; `normalX`, `normalY`, `normalZ` without prefix.
  Type type = Type::kDouble;
  int bits = 64;                     ///< Of a value in the bytestream, 0 to 64.
  std::int64_t minimum = 0;          ///< Integers: the value whose bits are all zero.
  double scale = 1.0, offset = 0.0;  ///< Value = scale * integer + offset.
  std::optional<E57Limits> limits;   ///< Of the values, where the field tells.
};

/// Rows and columns of a grid, last ones included.
struct E57IndexBounds {
  std::int64_t row_minimum = 0, row_maximum = 0, column_minimum = 0, column_maximum = 0;
};

/// What the XML section tells about one scan.
struct E57Scan {
  std::string name, guid;
  std::uint64_t section_offset = 0;  ///< Physical, of the points.
  std::uint64_t record_count = 0;
  std::vector<E57Field> fields;
  std::optional<RigidMotion> world_from_view;
  std::optional<E57IndexBounds> index_bounds;
  std::array<std::optional<E57Limits>, 3> colour_limits;
  std::optional<E57Limits> intensity_limits;

  const E57Field* find(std::string_view field) const;
};

/// The number of bits that hold every integer from `minimum` to `maximum`.
int e57_bits_between(std::int64_t minimum, std::int64_t maximum);

/// Reads the XML section. kBadInput names the scan (counted from 0), the element, and the remedy.
Result<std::vector<E57Scan>> read_e57_layout(E57Pages& pages);

}  // namespace relief
