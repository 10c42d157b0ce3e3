#include "scan/io/images/codecs/floats/npy_header.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <set>
#include <string>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/little_endian.h"

namespace relief {

namespace {

constexpr std::string_view kNpyMagic("\x93NUMPY", 6);

// The dictionary of Python: {'descr': '<f4', 'fortran_order': False, 'shape': (480, 640), }
class NpyDictionary {
 public:
  explicit NpyDictionary(std::string_view text) : text_(text), rest_(text) {}

  std::size_t place() const { return text_.size() - rest_.size(); }

  // False: not such a dictionary, from place() on.
  bool read(NpyHeader& header) {
    if (!take('{')) return false;
    while (!take('}')) {
      const auto key = take_text();
      if (!key || !take(':') || !read_value(*key, header)) return false;
      seen_.insert(std::string(*key));
      if (!take(',') && !next_is('}')) return false;
    }
    return seen_.size() == 3;
  }

 private:
  void skip_blanks() {
    while (!rest_.empty() && std::isspace(static_cast<unsigned char>(rest_.front())))
      rest_.remove_prefix(1);
  }
  bool next_is(char letter) {
    skip_blanks();
    return rest_.starts_with(letter);
  }
  bool take(char letter) {
    if (!next_is(letter)) return false;
    rest_.remove_prefix(1);
    return true;
  }
  bool take_word(std::string_view word) {
    skip_blanks();
    if (!rest_.starts_with(word)) return false;
    rest_.remove_prefix(word.size());
    return true;
  }
  std::optional<std::string_view> take_text() {
    skip_blanks();
    if (!rest_.starts_with('\'') && !rest_.starts_with('"')) return std::nullopt;
    const std::size_t end = rest_.find(rest_.front(), 1);
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view text = rest_.substr(1, end - 1);
    rest_.remove_prefix(end + 1);
    return text;
  }

  bool read_value(std::string_view key, NpyHeader& header) {
    if (seen_.contains(std::string(key))) return false;
    if (key == "descr") return read_type(header);
    if (key == "shape") return read_shape(header);
    if (key != "fortran_order") return false;
    header.columns_first = take_word("True");
    return header.columns_first || take_word("False");
  }

  bool read_type(NpyHeader& header) {
    const auto type = take_text();
    if (!type || type->empty()) return false;
    const bool has_order = std::string_view("<>|=").find(type->front()) != std::string_view::npos;
    const std::string_view kind_and_bytes = type->substr(has_order ? 1 : 0);
    if (kind_and_bytes.size() < 2) return false;
    header.order = !has_order || type->front() == '=' ? '<' : type->front();
    header.kind = kind_and_bytes.front();
    const char* const last = kind_and_bytes.data() + kind_and_bytes.size();
    const auto [end, error] = std::from_chars(kind_and_bytes.data() + 1, last, header.bytes);
    return error == std::errc() && end == last;
  }

  bool read_shape(NpyHeader& header) {
    if (!take('(')) return false;
    while (!take(')')) {
      skip_blanks();
      std::size_t size = 0;
      const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), size);
      if (error != std::errc()) return false;
      rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
      if (rest_.starts_with('L')) rest_.remove_prefix(1);  // A long integer of Python 2.
      header.shape.push_back(size);
      if (!take(',') && !next_is(')')) return false;
    }
    return true;
  }

  std::string_view text_, rest_;
  std::set<std::string> seen_;
};

template <typename T>
std::vector<double> floats_of(std::string_view bytes, std::size_t limit) {
  static_assert(std::endian::native == std::endian::little);
  std::vector<T> numbers(std::min(limit, bytes.size() / sizeof(T)));
  if (numbers.empty()) return {};
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(T));
  return std::vector<double>(numbers.begin(), numbers.end());
}

}  // namespace

std::vector<std::size_t> image_shape(const NpyHeader& header) {
  const auto is_image = [](const std::vector<std::size_t>& shape) {
    return shape.size() < 3 || (shape.size() == 3 && (shape[2] == 1 || shape[2] == 3));
  };
  std::vector<std::size_t> shape = header.shape;
  while (!is_image(shape) && shape.front() == 1) shape.erase(shape.begin());
  return shape;
}

Result<NpyHeader> read_npy_header(std::string_view content, const std::filesystem::path& path) {
  if (!content.starts_with(kNpyMagic)) return bad_input(path, "not a NumPy file (no \\x93NUMPY)");
  if (content.size() < 12) return bad_input(path, "truncated: ends within the NumPy header");
  const int version = static_cast<unsigned char>(content[6]);
  if (version < 1 || version > 3)
    return bad_input(path, "byte 6: version " + std::to_string(version) +
                               " of the NumPy format is unknown; 1 to 3 are read");
  const std::size_t text_at = version == 1 ? 10 : 12;
  const std::size_t text_bytes = version == 1 ? little_endian_at<std::uint16_t>(content, 8)
                                              : little_endian_at<std::uint32_t>(content, 8);
  if (text_bytes > content.size() - text_at)
    return bad_input(path, "truncated: the NumPy header has " + std::to_string(text_bytes) +
                               " bytes, " + std::to_string(content.size() - text_at) + " follow");
  NpyDictionary dictionary(content.substr(text_at, text_bytes));
  NpyHeader header;
  if (!dictionary.read(header))
    return bad_input(path, "byte " + std::to_string(text_at + dictionary.place()) +
                               ": expected {'descr': '<f4', 'fortran_order': False, 'shape': "
                               "(ROWS, COLUMNS)}; tables of fields are not read");
  header.numbers_at = text_at + text_bytes;
  return header;
}

std::vector<double> read_npy_floats(std::string_view content, const NpyHeader& header) {
  if (header.kind != 'f' || header.order != '<') return {};
  const bool is_matrix = header.shape.size() == 2;
  if (header.columns_first && !is_matrix) return {};
  const std::string_view bytes = content.substr(header.numbers_at);
  std::size_t count = 1;  // No more than there are bytes: it cannot overflow.
  for (const std::size_t size : header.shape)
    count = size > 0 && count > bytes.size() / size ? bytes.size() : count * size;
  std::vector<double> numbers;
  if (header.bytes == 4) numbers = floats_of<float>(bytes, count);
  if (header.bytes == 8) numbers = floats_of<double>(bytes, count);
  if (!header.columns_first) return numbers;
  const std::size_t rows = header.shape[0], columns = header.shape[1];
  if (rows == 0 || numbers.size() / rows < columns) return {};
  std::vector<double> by_rows(rows * columns);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c) by_rows[r * columns + c] = numbers[c * rows + r];
  return by_rows;
}

}  // namespace relief
