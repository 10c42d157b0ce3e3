#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "scan/io/files/file_ending.h"
#include "scan/io/workspaces/rgbd/poses/named_poses.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// tx ty tz qx qy qz qw.
constexpr std::size_t kNumbersOfPose = 7;
constexpr std::array<std::string_view, kNumbersOfPose> kAxes = {"x", "y", "z", "x", "y", "z", "w"};

// Which of the seven numbers a column holds by its name: `tx`, `pos_x`, `rot.w`, `q_w`, `x`.
std::optional<std::size_t> number_named(std::string_view name) {
  std::string word = lower_case(std::string(name));
  std::erase_if(word, [](char c) { return c == '_' || c == '.' || c == '-'; });
  const auto is_named = [&](std::size_t k, std::initializer_list<std::string_view> kinds) {
    return std::ranges::any_of(
        kinds, [&](std::string_view kind) { return word == std::string(kind) + kAxes[k].data(); });
  };
  for (std::size_t k = 0; k < kNumbersOfPose; ++k)
    if (k < 3 ? is_named(k, {"", "t", "p", "pos", "position", "trans", "translation"})
              : is_named(k, {"q", "quat", "quaternion", "rot", "rotation", "orientation"}))
      return k;
  return std::nullopt;
}

// Where a line holds the numbers of a pose, and what else it holds.
struct Columns {
  std::array<std::size_t, kNumbersOfPose> numbers = {};
  std::map<std::size_t, std::string> others;  // Their names.
  std::size_t count = 0;
};

// The columns that a heading names, if it names all seven numbers.
std::optional<Columns> columns_named(const std::vector<std::string_view>& heading) {
  Columns columns;
  columns.count = heading.size();
  std::array<bool, kNumbersOfPose> named = {};
  for (std::size_t i = 0; i < heading.size(); ++i) {
    const auto number = number_named(heading[i]);
    if (!number) columns.others[i] = heading[i];
    if (!number) continue;
    if (named[*number]) return std::nullopt;
    named[*number] = true;
    columns.numbers[*number] = i;
  }
  return std::ranges::all_of(named, std::identity()) ? std::optional(columns) : std::nullopt;
}

Columns columns_behind_name() { return {{1, 2, 3, 4, 5, 6, 7}, {{0, ""}}, 1 + kNumbersOfPose}; }

std::vector<double> numbers_behind_name(std::string_view line) {
  next_word(line);
  return leading_numbers(line);
}

// Whether a line is a name with the numbers of a pose behind it.
bool is_named_pose(std::string_view line) {
  const auto words = words_of(line);
  double number = 0.0;
  if (words.empty() || parse_number(words[0], number)) return false;
  const std::size_t count = numbers_behind_name(line).size();
  return count + 1 == words.size() && (count == kNumbersOfPose || count == 12 || count == 16);
}

// A line whose cells stand between commas or semicolons, with `nan` in the empty ones.
std::string with_cells_filled(std::string_view line) {
  std::string filled;
  bool empty = true;
  const auto fill = [&] {
    if (empty) filled += "nan";
    empty = true;
  };
  for (const char c : line) {
    const bool separates = c == ',' || c == ';';
    if (separates)
      fill();
    else
      empty = empty && is_blank(c);
    filled += c;
  }
  fill();
  return filled;
}

// Nothing for a pose that is lost.
Result<std::optional<RigidMotion>> pose_of(std::string_view line, const Columns& columns,
                                           const NumberedLines& lines) {
  const auto words = words_of(line);
  if (words.size() == columns.count) {
    std::array<double, kNumbersOfPose> numbers;
    for (std::size_t k = 0; k < kNumbersOfPose; ++k) {
      const std::string_view word = words[columns.numbers[k]];
      if (!parse_number(word, numbers[k]))
        return lines.error("expected a number, found '" + std::string(word) + "'");
    }
    if (are_lost(numbers)) return std::optional<RigidMotion>();
    const auto motion = motion_of_tum_numbers(numbers, lines);
    return motion ? Result(std::optional(*motion)) : motion.error();
  }
  const auto matrix = numbers_behind_name(line);
  const bool is_matrix = matrix.size() == 12 || matrix.size() == 16;
  if (!is_matrix || words.size() != matrix.size() + 1 || words.size() < columns.count)
    return lines.error("expected a pose as on the lines above");
  if (are_lost(matrix)) return std::optional<RigidMotion>();
  const auto motion = motion_of_numbers(matrix, "the matrix");
  if (!motion) return lines.error(motion.error().message);
  return std::optional(*motion);
}

constexpr std::string_view kSeparators = ",;\"";

}  // namespace

Result<PoseList> parse_pose_table(std::string_view text, const fs::path& path) {
  NumberedLines lines(text, path);
  PoseList poses;
  std::optional<Columns> columns;
  for (std::string_view line; lines.next(line);) {
    std::string cells = with_blanks(line, kSeparators);
    auto words = words_of(cells);
    if (columns && words.size() < columns->count) {
      cells = with_blanks(with_cells_filled(line), kSeparators);
      words = words_of(cells);
    }
    if (!columns) {
      columns = columns_named(words);
      if (columns) continue;
      if (!is_named_pose(cells)) return poses;  // Some other text.
      columns = columns_behind_name();
      poses.is_ordered = false;
    }
    const auto pose = pose_of(cells, *columns, lines);
    if (!pose) return pose.error();
    poses.world_from_view.push_back(*pose);
    for (const auto& [column, name] : columns->others)
      poses.names[name].emplace_back(words[column]);
  }
  return poses;
}

}  // namespace relief
