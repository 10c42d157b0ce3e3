#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "scan/io/clouds/files/point_cloud_file.h"
#include "scan/io/clouds/files/xyz_columns.h"
#include "scan/io/clouds/grey_of_intensity.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/text_lines.h"

namespace relief {

namespace {

constexpr std::size_t kMostColumns = 64;
constexpr double kLevels = 255.0;  // The largest value of a byte.

std::string_view without_comment_mark(std::string_view line) {
  while (!line.empty() && (line.front() == '#' || line.front() == '/')) line.remove_prefix(1);
  return line;
}

// Splits the text into numbers and keeps what its other lines tell.
class XyzParser {
 public:
  XyzParser(std::string_view content, const std::filesystem::path& path)
      : rest_(without_byte_order_mark(content)), path_(path) {}

  Result<PointCloudFile> parse() {
    if (rest_.starts_with("\xff\xfe") || rest_.starts_with("\xfe\xff"))
      return bad_input(path_, "holds UTF-16 text; save it as UTF-8 or plain text");
    while (!rest_.empty()) {
      ++line_number_;
      if (auto parsed = parse_line(next_line(rest_)); !parsed) return parsed.error();
    }
    if (auto counted = end_block(); !counted) return counted.error();
    if (table_.values.empty()) return bad_input(path_, "no point in the file");
    const auto columns = find_columns();
    if (!columns) return columns.error();
    return cloud_from(*columns);
  }

 private:
  Error at_line(const std::string& what) const {
    return bad_input(path_, "line " + std::to_string(line_number_) + ": " + what);
  }

  Result<void> parse_line(std::string_view line) {
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    if (line.empty()) return {};
    if (line.starts_with('#') || line.starts_with("//")) {
      if (table_.values.empty()) take_names(without_comment_mark(line), true);
      return {};
    }
    return parse_numbers(line);
  }

  // A comment is taken for names only if it tells of nothing else.
  bool take_names(std::string_view line, bool comment) {
    std::size_t names = 0, unknown = 0;
    const auto columns = columns_by_name(line, names, unknown);
    if (!columns || (comment && unknown > names / 2)) return false;
    named_ = columns;
    names_ = names;
    names_in_comment_ = comment;
    return true;
  }

  Result<void> parse_numbers(std::string_view line) {
    const std::size_t before = table_.values.size();
    std::string_view left = line;
    for (auto field = next_field(left); !field.empty(); field = next_field(left)) {
      double value = 0.0;
      if (!parse_number(field, value)) return no_number(line, field, before);
      if (table_.values.size() - before == kMostColumns)
        return at_line("more than " + std::to_string(kMostColumns) + " numbers");
      table_.values.push_back(value);
    }
    const std::size_t columns = table_.values.size() - before;
    if (columns == 0) return at_line("no number between the separators");
    if (columns == 1) return begin_block(before);
    if (table_.columns == 0) return begin_table(line, columns);
    if (columns != table_.columns)
      return at_line(std::to_string(columns) + " numbers, but the points before have " +
                     std::to_string(table_.columns));
    return {};
  }

  Result<void> begin_table(std::string_view line, std::size_t columns) {
    if (has_decimal_commas(line))
      return at_line("decimals have commas; write them with a point, as 1.5");
    if (columns < 3) return at_line("a point has at least three numbers: x y z");
    table_.columns = columns;
    if (!named_ || names_ == columns) return {};
    if (!names_in_comment_)
      return at_line(std::to_string(columns) + " numbers, but " + std::to_string(names_) +
                     " columns are named before");
    named_.reset();
    return {};
  }

  Result<void> no_number(std::string_view line, std::string_view field, std::size_t before) {
    table_.values.resize(before);
    if (before == 0 && !named_ && take_names(line, false)) return {};
    const std::string word = "'" + std::string(field.substr(0, 40)) + "' is no number";
    return at_line(before == 0 ? word + "; a line of column names has x, y and z, as 'X Y Z R G B'"
                               : word + "; decimals have a point, and '#' begins a comment");
  }

  // The one number of a line says how many points follow.
  Result<void> begin_block(std::size_t before) {
    const double count = table_.values[before];
    table_.values.resize(before);
    if (!(count >= 0.0 && count <= 1e15) || count != std::floor(count))
      return at_line("a single number says how many points follow, and is a whole one");
    if (auto counted = end_block(); !counted) return counted;
    promised_ = static_cast<std::size_t>(count);
    block_start_ = table_.rows();
    block_line_ = line_number_;
    return {};
  }

  Result<void> end_block() {
    const std::size_t found = table_.rows() - block_start_;
    if (!promised_ || found == *promised_) return {};
    const std::string promise = "line " + std::to_string(block_line_) + " promises " +
                                std::to_string(*promised_) + " points, ";
    if (found < *promised_)
      return bad_input(path_, "truncated: " + promise + std::to_string(*promised_ - found) +
                                  " lines are missing; export it again");
    notes_.push_back(promise + std::to_string(found) + " follow and are read");
    return {};
  }

  Result<XyzColumns> find_columns() const {
    if (named_) return *named_;
    if (is_trajectory(table_))
      return bad_input(path_,
                       "holds poses (each line ends in a unit quaternion), not points; give "
                       "it beside the folder of depth maps that it belongs to");
    if (const auto columns = columns_by_content(table_)) return *columns;
    return bad_input(path_, "the meaning of its " + std::to_string(table_.columns) +
                                " columns is not clear: behind x y z there are neither unit "
                                "normals nor whole colours from 0 to 255; begin the file with a "
                                "line of column names, as 'X Y Z Nx Ny Nz R G B Intensity'");
  }

  Eigen::Vector3d vector_at(std::size_t row, const XyzColumns::Three& columns) const {
    return {table_.at(row, columns[0]), table_.at(row, columns[1]), table_.at(row, columns[2])};
  }

  // Real colours from 0 to 1 are stretched.
  double level_factor(const XyzColumns::Three& columns) const {
    bool whole = true;
    double largest = 0.0;
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      for (const double value : vector_at(row, columns)) {
        if (!std::isfinite(value)) continue;
        whole = whole && value == std::floor(value);
        largest = std::max(largest, value);
      }
    }
    return !whole && largest <= 1.0 ? kLevels : 1.0;
  }

  static Colour colour_of(const Eigen::Vector3d& levels) {
    Colour colour{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double level = levels[static_cast<Eigen::Index>(k)];
      if (std::isfinite(level))
        colour[k] = static_cast<std::uint8_t>(std::lround(std::clamp(level, 0.0, kLevels)));
    }
    return colour;
  }

  Result<PointCloudFile> cloud_from(const XyzColumns& columns) {
    PointCloudFile cloud;
    cloud.notes = std::move(notes_);
    cloud.points.reserve(table_.rows());
    const double factor = columns.colour ? level_factor(*columns.colour) : 1.0;
    GreyOfIntensity grey;
    if (columns.intensity && !columns.colour)
      for (std::size_t row = 0; row < table_.rows(); ++row)
        grey.add(table_.at(row, *columns.intensity));
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const Eigen::Vector3d point = vector_at(row, columns.position);
      if (!point.allFinite()) continue;
      cloud.points.push_back(point);
      if (columns.normal) cloud.normals.push_back(vector_at(row, *columns.normal).cast<float>());
      if (columns.colour)
        cloud.colours.push_back(colour_of(factor * vector_at(row, *columns.colour)));
      if (grey.known()) cloud.colours.push_back(grey.grey(table_.at(row, *columns.intensity)));
    }
    if (cloud.points.empty()) return bad_input(path_, "no point of the file is finite");
    if (const std::size_t left_out = table_.rows() - cloud.points.size())
      cloud.notes.push_back(std::to_string(left_out) + " points that are not finite are left out");
    return cloud;
  }

  std::string_view rest_;
  const std::filesystem::path& path_;
  std::size_t line_number_ = 0;
  NumberTable table_;
  std::optional<XyzColumns> named_;
  std::size_t names_ = 0;
  bool names_in_comment_ = false;
  std::optional<std::size_t> promised_;
  std::size_t block_start_ = 0, block_line_ = 0;
  std::vector<std::string> notes_;
};

}  // namespace

Result<PointCloudFile> parse_xyz(std::string_view content, const std::filesystem::path& path) {
  return XyzParser(content, path).parse();
}

}  // namespace relief
