#include "scan/io/clouds/files/ptx_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "scan/io/clouds/grey_of_intensity.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/mapped_file.h"
#include "scan/io/files/text_lines.h"

namespace relief {

namespace {

// The shortest line of a point: `0 0 0` and its end.
constexpr std::size_t kLeastPointBytes = 6;
constexpr std::size_t kHeaderLines = 10;

std::string ptx_word(std::string_view word) { return "'" + std::string(word.substr(0, 40)) + "'"; }

// Before the points of a scan.
struct PtxHeader {
  std::size_t columns = 0, rows = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix4d world_from_view = Eigen::Matrix4d::Identity();
  std::size_t first_line = 0, matrix_line = 0;  // Counted from 1.

  std::size_t places() const { return columns * rows; }
};

// Reads one scan after the other. Empty lines do not count.
class PtxParser {
 public:
  PtxParser(std::string_view content, const std::filesystem::path& path,
            std::size_t lines_before = 0)
      : rest_(without_byte_order_mark(content)), path_(path), line_number_(lines_before) {}

  std::size_t bytes_left() const { return rest_.size(); }
  std::size_t lines_read() const { return line_number_; }

  // Whether something follows.
  bool has_more() const {
    return std::any_of(rest_.begin(), rest_.end(),
                       [](char c) { return c != '\n' && !is_blank(c); });
  }

  Result<PtxHeader> read_header() {
    PtxHeader header;
    const std::array<std::size_t PtxHeader::*, 2> sizes{&PtxHeader::columns, &PtxHeader::rows};
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      const auto size = read_size(k == 0 ? "columns" : "rows");
      if (!size) return size.error();
      header.*sizes[k] = *size;
      if (k == 0) header.first_line = line_number_;
    }
    std::array<double, 4> values{};
    for (std::size_t line = 2; line < kHeaderLines; ++line) {
      const bool in_matrix = line >= 6;
      if (auto read = read_numbers(in_matrix ? 4 : 3, line, values); !read) return read.error();
      if (line == 2) header.position = {values[0], values[1], values[2]};
      if (line == 6) header.matrix_line = line_number_;
      // Row vectors are multiplied from the left.
      if (in_matrix)
        header.world_from_view.col(static_cast<Eigen::Index>(line - 6)) =
            Eigen::Vector4d(values.data());
    }
    if (auto room = check_room(header); !room) return room.error();
    return header;
  }

  Result<void> skip_points(const PtxHeader& header) {
    for (std::size_t i = 0; i < header.places(); ++i)
      if (next_full_line().empty()) return missing(header, i);
    return {};
  }

  Result<GridFile> read_points(const PtxHeader& header);

  Error at_line(std::size_t line, const std::string& what) const {
    return bad_input(path_, "line " + std::to_string(line) + ": " + what);
  }

 private:
  struct PointLine {
    Eigen::Vector3d point = Eigen::Vector3d::Constant(kNoSample);
    double intensity = 0.0;
    Colour colour{};
    int numbers = 0;
  };

  std::string_view next_full_line() {
    while (!rest_.empty()) {
      ++line_number_;
      const std::string_view line = next_line(rest_);
      if (!std::all_of(line.begin(), line.end(), is_blank)) return line;
    }
    return {};
  }

  Error missing(const PtxHeader& header, std::size_t found) const {
    return bad_input(path_, "the scan that begins in line " + std::to_string(header.first_line) +
                                " is truncated: " + std::to_string(header.columns) +
                                " columns of " + std::to_string(header.rows) +
                                " points promised, " + std::to_string(header.places() - found) +
                                " lines missing at the end; export it again");
  }

  Result<void> check_room(const PtxHeader& header) {
    if ((rest_.size() + 1) / kLeastPointBytes >= header.places()) return {};
    std::size_t found = 0;
    while (!next_full_line().empty()) ++found;
    return missing(header, std::min(found, header.places()));
  }

  Result<std::size_t> read_size(const std::string& what) {
    std::string_view line = next_full_line();
    if (line.empty())
      return bad_input(path_, "the file ends before the number of " + what +
                                  "; it is empty or truncated: export it again");
    const std::string_view word = next_word(line);
    int value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || value < 1 ||
        !next_word(line).empty())
      return at_line(line_number_, ptx_word(word) + " is no number of " + what +
                                       "; a PTX scan begins with columns and rows, a line each");
    return static_cast<std::size_t>(value);
  }

  Result<void> read_numbers(std::size_t count, std::size_t header_line,
                            std::array<double, 4>& values) {
    std::string_view line = next_full_line();
    if (line.empty())
      return bad_input(path_, "truncated: " + std::to_string(kHeaderLines - header_line) +
                                  " lines of the scan's header are missing; export it again");
    for (std::size_t k = 0; k < count; ++k) {
      const std::string_view word = next_word(line);
      if (!parse_number(word, values[k]) || !std::isfinite(values[k]))
        return at_line(line_number_, ptx_word(word) + " is no finite number; expected " +
                                         std::to_string(count) + " of them in this line");
    }
    if (!next_word(line).empty())
      return at_line(line_number_, "expected " + std::to_string(count) + " numbers, not more");
    return {};
  }

  Result<PointLine> parse_point(std::string_view line) const {
    PointLine parsed;
    std::array<double, 7> values{};
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      if (parsed.numbers == 7) return at_line(line_number_, "more than 7 numbers in a point");
      if (!parse_number(word, values[static_cast<std::size_t>(parsed.numbers)]))
        return at_line(line_number_, ptx_word(word) + " is no number");
      ++parsed.numbers;
    }
    if (parsed.numbers != 3 && parsed.numbers != 4 && parsed.numbers != 7)
      return at_line(line_number_, "a point has 3, 4 or 7 numbers: x y z intensity red green blue");
    const Eigen::Vector3d point(values.data());
    if (point.allFinite() && !point.isZero(0.0)) parsed.point = point;
    parsed.intensity = values[3];
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(values[4 + k] >= 0.0 && values[4 + k] <= 255.0))
        return at_line(line_number_, "red, green and blue are numbers from 0 to 255");
      parsed.colour[k] = static_cast<std::uint8_t>(values[4 + k]);
    }
    return parsed;
  }

  std::string_view rest_;
  const std::filesystem::path& path_;
  std::size_t line_number_;
};

// Where points have no colours, the intensities become them.
void set_greys(const Grid<double>& intensities, GridFile& grid) {
  GreyOfIntensity scale;
  for (std::size_t i = 0; i < grid.points.size(); ++i)
    if (grid.points[i].allFinite()) scale.add(intensities[i]);
  if (!scale.known()) return;
  grid.colours = Grid<Colour>(grid.points.width(), grid.points.height());
  for (std::size_t i = 0; i < grid.points.size(); ++i)
    if (grid.points[i].allFinite()) grid.colours[i] = scale.grey(intensities[i]);
}

Result<GridFile> PtxParser::read_points(const PtxHeader& header) {
  const int width = static_cast<int>(header.columns), height = static_cast<int>(header.rows);
  GridFile grid;
  grid.points = Grid<Eigen::Vector3d>(width, height, Eigen::Vector3d::Constant(kNoSample));
  Grid<double> intensities;
  int numbers = 0;
  for (int u = 0; u < width; ++u) {
    for (int v = height - 1; v >= 0; --v) {
      const std::string_view line = next_full_line();
      if (line.empty()) {
        const auto above = static_cast<std::size_t>(height - 1 - v);
        return missing(header, static_cast<std::size_t>(u) * header.rows + above);
      }
      const auto parsed = parse_point(line);
      if (!parsed) return parsed.error();
      if (numbers == 0) {
        numbers = parsed->numbers;
        if (numbers == 4) intensities = Grid<double>(width, height);
        if (numbers == 7) grid.colours = Grid<Colour>(width, height);
      }
      if (parsed->numbers != numbers)
        return at_line(line_number_, std::to_string(parsed->numbers) +
                                         " numbers, but the points before have " +
                                         std::to_string(numbers));
      grid.points(u, v) = parsed->point;
      if (numbers == 4) intensities(u, v) = parsed->intensity;
      if (numbers == 7) grid.colours(u, v) = parsed->colour;
    }
  }
  if (numbers == 4) set_greys(intensities, grid);
  return grid;
}

std::string vector_words(const Eigen::Vector3d& vector) {
  std::string text;
  for (const double value : vector) text += (text.empty() ? "" : " ") + std::to_string(value);
  return text;
}

Result<void> set_pose(const PtxHeader& header, const PtxParser& parser, GridFile& grid) {
  if (header.world_from_view == Eigen::Matrix4d::Identity()) {
    if (!header.position.isZero(0.0))
      grid.notes.push_back("the matrix is the identity, but the scanner stands at " +
                           vector_words(header.position) + ": points are taken as they are");
    return {};
  }
  const auto pose = rigid_motion_from_matrix(header.world_from_view, "the matrix of the scan");
  if (!pose)
    return parser.at_line(header.matrix_line,
                          pose.error().message +
                              "; export the scan again with a rotation and a translation here, or "
                              "with the matrix applied to the points and the identity here");
  grid.world_from_view = *pose;
  return {};
}

Result<void> apply_matrix(const PtxHeader& header, const PtxParser& parser, GridFile& grid) {
  const Eigen::Affine3d world_from_view(header.world_from_view);
  if (header.world_from_view.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    return parser.at_line(header.matrix_line,
                          "the last column of the scan's matrix must be 0 0 0 1");
  if (header.world_from_view == Eigen::Matrix4d::Identity()) return {};
  for (auto& point : grid.points) point = world_from_view * point;
  return {};
}

// Calls `passed` after each scan.
template <typename Passed>
Result<std::vector<PtxScan>> find_scans(std::string_view content, const std::filesystem::path& path,
                                        const Passed& passed) {
  PtxParser parser(content, path);
  std::vector<PtxScan> scans;
  do {
    PtxScan& scan = scans.emplace_back();
    scan.begin = content.size() - parser.bytes_left();
    scan.lines_before = parser.lines_read();
    const auto header = parser.read_header();
    if (!header) return header.error();
    if (auto skipped = parser.skip_points(*header); !skipped) return skipped.error();
    scan.end = content.size() - parser.bytes_left();
    scan.has_pose = header->world_from_view != Eigen::Matrix4d::Identity();
    passed(scan);
  } while (parser.has_more());
  return scans;
}

Result<GridFile> parse_points(const PtxHeader& header, PtxMatrix matrix, PtxParser& parser) {
  // Before the points: an error there takes no time to find.
  GridFile told;
  if (matrix == PtxMatrix::kPose)
    if (auto pose = set_pose(header, parser, told); !pose) return pose.error();
  auto grid = parser.read_points(header);
  if (!grid) return grid;
  grid->world_from_view = told.world_from_view;
  grid->notes = std::move(told.notes);
  if (matrix == PtxMatrix::kApply)
    if (auto applied = apply_matrix(header, parser, *grid); !applied) return applied.error();
  return grid;
}

}  // namespace

Result<GridFile> parse_ptx_scan(std::string_view content, const std::filesystem::path& path,
                                int scan, PtxMatrix matrix) {
  PtxParser parser(content, path);
  for (int i = 0;; ++i) {
    if (scan < 0 || (i > 0 && !parser.has_more()))
      return bad_input(path, "there is no scan " + std::to_string(scan) + "; it holds " +
                                 std::to_string(i) + ", counted from 0");
    const auto header = parser.read_header();
    if (!header) return header.error();
    if (i < scan) {
      if (auto skipped = parser.skip_points(*header); !skipped) return skipped.error();
      continue;
    }
    return parse_points(*header, matrix, parser);
  }
}

Result<std::vector<PtxScan>> list_ptx_scans(std::string_view content,
                                            const std::filesystem::path& path) {
  return find_scans(content, path, [](const PtxScan&) {});
}

Result<std::vector<PtxScan>> list_ptx_scans(const std::filesystem::path& path) {
  const auto file = MappedFile::open(path);
  if (!file) return file.error();
  return find_scans(file->content(), path,
                    [&](const PtxScan& scan) { file->release_before(scan.end); });
}

Result<GridFile> read_ptx_scan(const std::filesystem::path& path, int scan, PtxMatrix matrix) {
  const auto content = read_file(path);
  if (!content) return content.error();
  return parse_ptx_scan(*content, path, scan, matrix);
}

Result<GridFile> read_ptx_scan(const std::filesystem::path& path, const PtxScan& scan,
                               PtxMatrix matrix) {
  const auto content = read_file(path, scan.begin, scan.end);
  if (!content) return content.error();
  PtxParser parser(*content, path, scan.lines_before);
  const auto header = parser.read_header();
  if (!header) return header.error();
  return parse_points(*header, matrix, parser);
}

}  // namespace relief
