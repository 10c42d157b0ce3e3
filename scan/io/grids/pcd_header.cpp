#include "scan/io/grids/pcd_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scan/io/files/io_error.h"
#include "scan/io/files/text_lines.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

constexpr std::size_t kMaxPoints = (std::size_t{1} << 31) - 1;  // In one row.
// Bounds products of what a header says. No point is longer.
constexpr std::size_t kMaxCount = 1u << 16;
// LZF's longest copy is 264 bytes for three.
constexpr std::size_t kMaxCompression = 100;
constexpr std::size_t kSizesOfCompressed = 8;  // [bytes]

bool parse_count(std::string_view word, std::size_t& value) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return !word.empty() && error == std::errc() && end == word.data() + word.size();
}

class PcdHeaderReader {
 public:
  PcdHeaderReader(const std::filesystem::path& path, bool organized)
      : path_(path), organized_(organized), file_(path, std::ios::binary) {}

  Result<PcdHeader> read() {
    if (!file_) return bad_input(path_, "cannot be read");
    for (std::string text; read_line(file_, text);) {
      if (++line_number_ == 1) header_.ends_in_return = last_byte() == '\r';
      std::string_view line = text;
      const std::string_view keyword = next_word(line);
      if (keyword.empty() || keyword.front() == '#') continue;
      if (auto parsed = parse(keyword, line); !parsed) return parsed.error();
      if (keyword != "DATA") continue;
      // Behind a return alone, a line feed is the first byte of the data.
      if (header_.ends_in_return && last_byte() == '\n') file_.unget();
      const auto position = file_.tellg();
      if (position < 0) return bad_input(path_, "truncated PCD: the file ends with its header");
      header_.data_start = static_cast<std::size_t>(position);
      if (auto checked = check(); !checked) return checked.error();
      return header_;
    }
    return bad_input(path_, "damaged PCD header: the file ends before a line DATA");
  }

 private:
  // Before the present position.
  int last_byte() {
    if (!file_.unget()) return EOF;
    return file_.get();
  }

  Error at_line(const std::string& what) const {
    return bad_input(path_, "line " + std::to_string(line_number_) + " of the PCD header: " + what);
  }

  Result<void> parse(std::string_view keyword, std::string_view line) {
    if (!known_.insert(std::string(keyword)).second)
      return at_line("a second line " + std::string(keyword.substr(0, 40)));
    if (keyword == "SIZE") return parse_counts(line, sizes_);
    if (keyword == "COUNT") return parse_counts(line, counts_);
    if (keyword == "WIDTH") return parse_number_of(line, header_.width);
    if (keyword == "HEIGHT") return parse_number_of(line, header_.height);
    if (keyword == "POINTS") return parse_number_of(line, header_.points);
    if (keyword == "DATA") return parse_data(line);
    if (keyword == "VIEWPOINT") take_viewpoint(line);
    if (keyword == "FIELDS" || keyword == "COLUMNS") count_fields(line);
    constexpr std::array<std::string_view, 5> kOthers{"FIELDS", "COLUMNS", "VERSION", "TYPE",
                                                      "VIEWPOINT"};
    if (std::find(kOthers.begin(), kOthers.end(), keyword) == kOthers.end())
      return at_line("unknown keyword '" + std::string(keyword.substr(0, 40)) + "'");
    return {};
  }

  void count_fields(std::string_view line) {
    for (std::string_view name = next_word(line); !name.empty(); name = next_word(line)) {
      ++header_.fields;
      header_.has_position |= name == "x";
    }
  }

  // What is wrong with the numbers is left to the reader of the points.
  void take_viewpoint(std::string_view line) {
    const std::vector<double> identity = {0, 0, 0, 1, 0, 0, 0};
    std::vector<double> numbers;
    for (double number; parse_number(next_word(line), number);) numbers.push_back(number);
    if (numbers.size() == identity.size() && numbers != identity) header_.viewpoint = numbers;
  }

  Result<void> parse_counts(std::string_view line, std::vector<std::size_t>& values) {
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      std::size_t value = 0;
      if (!parse_count(word, value) || value < 1 || value > kMaxCount)
        return at_line("'" + std::string(word.substr(0, 40)) + "' is no count from 1 to " +
                       std::to_string(kMaxCount));
      values.push_back(value);
    }
    return {};
  }

  Result<void> parse_number_of(std::string_view line, std::size_t& value) {
    const std::string_view word = next_word(line);
    if (!parse_count(word, value))
      return at_line("'" + std::string(word.substr(0, 40)) + "' is no whole number");
    return {};
  }

  Result<void> parse_data(std::string_view line) {
    const std::string_view kind = next_word(line);
    if (kind == "ascii")
      header_.data = PcdHeader::Data::kAscii;
    else if (kind == "binary")
      header_.data = PcdHeader::Data::kBinary;
    else if (kind == "binary_compressed")
      header_.data = PcdHeader::Data::kCompressed;
    else
      return at_line("DATA is ascii, binary or binary_compressed");
    return {};
  }

  Result<void> add_up_fields() {
    if (sizes_.empty() || sizes_.size() != header_.fields ||
        (!counts_.empty() && counts_.size() != sizes_.size()))
      return bad_input(path_,
                       "damaged PCD header: FIELDS, SIZE and COUNT tell of different numbers of "
                       "fields");
    constexpr std::array<std::size_t, 4> kSizes{1, 2, 4, 8};
    for (std::size_t i = 0; i < sizes_.size(); ++i) {
      if (std::find(kSizes.begin(), kSizes.end(), sizes_[i]) == kSizes.end())
        return bad_input(path_, "damaged PCD header: a SIZE is 1, 2, 4 or 8");
      const std::size_t count = counts_.empty() ? 1 : counts_[i];
      header_.values_per_point += count;
      header_.point_bytes += count * sizes_[i];
    }
    if (header_.point_bytes > kMaxCount)
      return bad_input(path_, "damaged PCD header: a point has more than " +
                                  std::to_string(kMaxCount) + " bytes");
    return {};
  }

  Result<void> check() {
    if (auto fields = add_up_fields(); !fields) return fields;
    if (header_.width == 0 && header_.height == 0 &&
        known_.contains("HEIGHT")) {  // Of programs that know POINTS alone.
      header_.width = header_.points;
      header_.height = 1;
      header_.sized_by_points = true;
    }
    const bool is_grid = organized_ && header_.height != 1;
    const std::size_t most = is_grid ? std::size_t{kMaxImageSide} : kMaxPoints;
    if (header_.width == 0 || header_.height == 0 || header_.width > most ||
        header_.height > most || header_.points > std::size_t{kMaxImageSide} * kMaxImageSide ||
        header_.points != header_.width * header_.height)
      return bad_input(path_, "bad size in the PCD header");
    std::error_code code;
    const std::size_t bytes = std::filesystem::file_size(path_, code);
    if (code || header_.data_start > bytes) return bad_input(path_, "truncated PCD");
    const std::size_t left = bytes - header_.data_start;
    if (left < least_bytes())
      return bad_input(path_, "truncated PCD: " + std::to_string(header_.points) +
                                  " points promised, " + std::to_string(left) +
                                  " bytes left for them");
    if (organized_ && !is_grid)
      return bad_input(path_,
                       "this PCD is not organized (HEIGHT 1); a scan needs the sensor's grid");
    return header_.data == PcdHeader::Data::kCompressed ? check_compressed(left) : Result<void>();
  }

  // What the promised points take at least.
  std::size_t least_bytes() const {
    const std::size_t promised = header_.points * header_.point_bytes;
    switch (header_.data) {
      case PcdHeader::Data::kAscii:  // A digit and what separates it from the next.
        return header_.points * header_.values_per_point * 2 - 1;
      case PcdHeader::Data::kBinary:
        return promised;
      case PcdHeader::Data::kCompressed:
        return kSizesOfCompressed + promised / kMaxCompression;
    }
    return promised;
  }

  // Compressed data begin with their two sizes.
  Result<void> check_compressed(std::size_t left) {
    std::array<unsigned char, kSizesOfCompressed> raw{};
    file_.read(reinterpret_cast<char*>(raw.data()), raw.size());
    const auto word = [&](std::size_t at) {
      std::size_t value = 0;
      for (std::size_t k = 4; k > 0; --k) value = value << 8 | raw[at + k - 1];
      return value;
    };
    if (word(0) > left - kSizesOfCompressed)
      return bad_input(path_, "truncated PCD: " + std::to_string(word(0)) +
                                  " compressed bytes promised, " +
                                  std::to_string(left - kSizesOfCompressed) + " left for them");
    if (word(4) != header_.points * header_.point_bytes)
      return bad_input(path_, "damaged PCD: " + std::to_string(word(4)) + " bytes for " +
                                  std::to_string(header_.points) + " points of " +
                                  std::to_string(header_.point_bytes));
    return {};
  }

  const std::filesystem::path& path_;
  bool organized_;
  std::ifstream file_;
  std::size_t line_number_ = 0;
  std::set<std::string> known_;
  std::vector<std::size_t> sizes_, counts_;
  PcdHeader header_;
};

}  // namespace

Result<PcdHeader> read_pcd_header(const std::filesystem::path& path, bool organized) {
  return PcdHeaderReader(path, organized).read();
}

}  // namespace relief
