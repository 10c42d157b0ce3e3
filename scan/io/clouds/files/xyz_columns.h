#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/result.h"

namespace relief {

/// Numbers in rows of equal length.
struct NumberTable {
  std::size_t columns = 0;
  std::vector<double> values;  ///< Row by row.

  std::size_t rows() const { return columns ? values.size() / columns : 0; }
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// Which columns of a table hold what.
struct XyzColumns {
  using Three = std::array<std::size_t, 3>;

  Three position{0, 1, 2};
  std::optional<Three> normal, colour;
  std::optional<std::size_t> intensity;
};

/// Takes the next field off a line. Blanks, tabs, commas and semicolons separate fields; quotes
/// around one are taken off. Empty at the end.
std::string_view next_field(std::string_view& line);

/// Whether a line has decimal commas, as `1,5 2 0,25`: commas stand inside of three fields or more
/// that other separators part, and none has two.
bool has_decimal_commas(std::string_view line);

/// The columns that a line of names tells; nothing when x, y or z is not among them. `unknown`
/// counts the names without meaning here.
std::optional<XyzColumns> columns_by_name(std::string_view line, std::size_t& names,
                                          std::size_t& unknown);

/// Whether the rows are poses: `[time] x y z qx qy qz qw` with unit quaternions.
bool is_trajectory(const NumberTable& table);

/// The columns that the numbers suggest, see parse_xyz; nothing when they do not.
std::optional<XyzColumns> columns_by_content(const NumberTable& table);

}  // namespace relief
