#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/text_lines.h"

namespace relief {

/// `text` without blanks at its ends.
std::string_view trimmed(std::string_view text);

/// `text` with blanks in place of all `signs`.
std::string with_blanks(std::string_view text, std::string_view signs);

/// The lines of a text with their numbers, for errors. Both arguments must outlive it.
class NumberedLines {
 public:
  NumberedLines(std::string_view text, const std::filesystem::path& path)
      : text_(without_byte_order_mark(text)), path_(path) {}

  /// The next line, trimmed, whatever it holds; false at the end of the text.
  bool next_any(std::string_view& line);
  /// The same for the next line that is neither empty nor a comment after `#`.
  bool next(std::string_view& line);

  int number() const { return number_; }
  const std::filesystem::path& path() const { return path_; }
  /// kBadInput: `file: line N: what`.
  Error error(const std::string& what) const;
  /// kBadInput: `file: the file ends where WHAT should be`.
  Error end_error(const std::string& what) const;

 private:
  std::string_view text_;
  const std::filesystem::path& path_;
  int number_ = 0;
};

/// Whether `line` holds `count` numbers, which `numbers` then has, and nothing else.
bool parse_row(std::string_view line, std::size_t count, double* numbers);

/// All words of a line that are numbers, up to the first that is none; at most `limit` of them.
std::vector<double> leading_numbers(std::string_view line, std::size_t limit = 32);

/// The words of a line; at most `limit`, of which the last is the rest of the line.
std::vector<std::string_view> words_of(std::string_view line, std::size_t limit = 64);

/// The motion x -> R(q) x + t. Nothing for numbers that are not finite, and for a quaternion whose
/// length differs from 1 by more than kRoundedQuaternion.
std::optional<RigidMotion> motion_of_quaternion(const Eigen::Quaterniond& q,
                                                const Eigen::Vector3d& t);

/// The motion of the numbers `tx ty tz qx qy qz qw` on the present line. kBadInput names the line.
Result<RigidMotion> motion_of_tum_numbers(std::span<const double, 7> numbers,
                                          const NumberedLines& lines);

/// The rigid motion of a 4x4 matrix by rows, of which the last may be missing, or by columns.
/// `numbers`: 12 or 16. Errors as those of rigid_motion_from_matrix.
Result<RigidMotion> motion_of_numbers(std::span<const double> numbers, const std::string& what);

/// Whether a tracker that lost the camera wrote the 7, 12 or 16 numbers of a pose: some are not
/// finite, or the quaternion, or all of the matrix but its last row, is 0.
bool are_lost(std::span<const double> numbers);

/// Reads rows of four numbers, the next four lines or the last three of the text: 16 or 12
/// numbers. Commas and brackets may stand between them. Errors name the line and `what`.
Result<std::vector<double>> parse_matrix_rows(NumberedLines& lines, const std::string& what);

/// Reads rows of four numbers, the next four lines or the last three of the text, as a rigid
/// motion, as parse_matrix_rows() does.
Result<RigidMotion> parse_motion_rows(NumberedLines& lines, const std::string& what);

/// `wanted`, made fit for a file name, and with a number behind it when `taken` says that it is in
/// use.
template <typename Taken>
std::string free_view_name(std::string wanted, const Taken& taken) {
  std::replace_if(
      wanted.begin(), wanted.end(), [](char c) { return c == '/' || c == '\\'; }, '_');
  std::string name = wanted;
  for (int i = 2; taken(name); ++i) name = wanted + "_" + std::to_string(i);
  return name;
}

}  // namespace relief
