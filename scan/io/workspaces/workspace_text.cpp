#include "scan/io/workspaces/workspace_text.h"

#include <algorithm>
#include <cmath>

#include "scan/io/files/unit_quaternion.h"

namespace relief {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string with_blanks(std::string_view text, std::string_view signs) {
  std::string blanked(text);
  std::ranges::replace_if(
      blanked, [&](char c) { return signs.find(c) != std::string_view::npos; }, ' ');
  return blanked;
}

bool NumberedLines::next_any(std::string_view& line) {
  if (text_.empty()) return false;
  line = trimmed(next_line(text_));
  ++number_;
  return true;
}

bool NumberedLines::next(std::string_view& line) {
  while (next_any(line))
    if (!line.empty() && line.front() != '#') return true;
  return false;
}

Error NumberedLines::error(const std::string& what) const {
  return bad_input(path_, "line " + std::to_string(number_) + ": " + what);
}

Error NumberedLines::end_error(const std::string& what) const {
  return bad_input(path_, "the file ends where " + what + " should be; it is truncated");
}

bool parse_row(std::string_view line, std::size_t count, double* numbers) {
  for (std::size_t i = 0; i < count; ++i)
    if (!parse_number(next_word(line), numbers[i])) return false;
  return next_word(line).empty();
}

std::vector<double> leading_numbers(std::string_view line, std::size_t limit) {
  std::vector<double> numbers;
  for (double number; numbers.size() < limit && parse_number(next_word(line), number);)
    numbers.push_back(number);
  return numbers;
}

std::vector<std::string_view> words_of(std::string_view line, std::size_t limit) {
  std::vector<std::string_view> words;
  while (words.size() + 1 < limit) {
    const std::string_view word = next_word(line);
    if (word.empty()) return words;
    words.push_back(word);
  }
  if (const std::string_view rest = trimmed(line); !rest.empty()) words.push_back(rest);
  return words;
}

std::optional<RigidMotion> motion_of_quaternion(const Eigen::Quaterniond& q,
                                                const Eigen::Vector3d& t) {
  if (!t.allFinite() || !(std::abs(q.norm() - 1.0) <= kRoundedQuaternion)) return std::nullopt;
  RigidMotion motion = RigidMotion::Identity();
  motion.linear() = q.normalized().toRotationMatrix();
  motion.translation() = t;
  return motion;
}

Result<RigidMotion> motion_of_tum_numbers(std::span<const double, 7> n,
                                          const NumberedLines& lines) {
  const auto motion =
      motion_of_quaternion(Eigen::Quaterniond(n[6], n[3], n[4], n[5]), {n[0], n[1], n[2]});
  if (!motion)
    return lines.error(
        "not a rigid motion: the quaternion qx qy qz qw must have length 1, and all numbers must "
        "be finite; remove the line if the pose is unknown");
  return *motion;
}

Result<RigidMotion> motion_of_numbers(std::span<const double> numbers, const std::string& what) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < numbers.size(); ++i)
    matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) = numbers[i];
  const Eigen::RowVector4d last(0.0, 0.0, 0.0, 1.0);
  if (matrix.row(3) != last && matrix.col(3) == last.transpose())
    matrix.transposeInPlace();  // Stored by columns, as graphics libraries do.
  return rigid_motion_from_matrix(matrix, what);
}

bool are_lost(std::span<const double> numbers) {
  const auto rotation = numbers.size() == 7 ? numbers.last(4) : numbers.first(12);
  return !std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); }) ||
         std::ranges::all_of(rotation, [](double number) { return number == 0.0; });
}

Result<std::vector<double>> parse_matrix_rows(NumberedLines& lines, const std::string& what) {
  std::vector<double> numbers(16);
  for (std::size_t r = 0; r < 4; ++r) {
    std::string_view line;
    if (!lines.next(line)) {
      if (r < 3) return lines.end_error("a row of four numbers of " + what);
      numbers.resize(12);
      break;
    }
    if (!parse_row(with_blanks(line, "[](),;"), 4, numbers.data() + 4 * r))
      return lines.error("expected a row of four numbers of " + what);
  }
  return numbers;
}

Result<RigidMotion> parse_motion_rows(NumberedLines& lines, const std::string& what) {
  const auto numbers = parse_matrix_rows(lines, what);
  if (!numbers) return numbers.error();
  auto motion = motion_of_numbers(*numbers, what);
  if (!motion) return lines.error(motion.error().message);
  return motion;
}

}  // namespace relief
