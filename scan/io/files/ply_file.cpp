#include "scan/io/files/ply_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <system_error>

#include "scan/base/parallel.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/mapped_file.h"
#include "scan/io/files/text_lines.h"

namespace relief {

namespace {

enum class Type : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
enum class Encoding { kAscii, kLittleEndian, kBigEndian };

struct TypeName {
  std::string_view name;
  Type type;
};
constexpr std::array<TypeName, 16> kTypeNames{{{"char", Type::kInt8},
                                               {"int8", Type::kInt8},
                                               {"uchar", Type::kUint8},
                                               {"uint8", Type::kUint8},
                                               {"short", Type::kInt16},
                                               {"int16", Type::kInt16},
                                               {"ushort", Type::kUint16},
                                               {"uint16", Type::kUint16},
                                               {"int", Type::kInt32},
                                               {"int32", Type::kInt32},
                                               {"uint", Type::kUint32},
                                               {"uint32", Type::kUint32},
                                               {"float", Type::kFloat},
                                               {"float32", Type::kFloat},
                                               {"double", Type::kDouble},
                                               {"float64", Type::kDouble}}};

std::optional<Type> type_of(std::string_view name) {
  for (const auto& entry : kTypeNames)
    if (entry.name == name) return entry.type;
  return std::nullopt;
}

std::size_t size_of(Type type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

std::string quoted(std::string_view text) {
  return "'" + std::string(text.substr(0, 40)) + (text.size() > 40 ? "...'" : "'");
}

struct PropertyType {
  Type value = Type::kFloat;
  Type count = Type::kUint8;  // of a list
};

// Reads the header, then the elements.
class PlyParser {
 public:
  PlyParser(std::string_view content, const std::filesystem::path& path,
            const std::function<void(std::size_t)>& parsed)
      : path_(path), parsed_(parsed), begin_(content.data()), rest_(content) {}

  Result<PlyFile> parse() {
    if (auto header = parse_header(); !header) return header.error();
    for (std::size_t e = 0; e < file_.elements.size(); ++e) {
      if (auto room = reserve(e); !room) return room.error();
      auto body = encoding_ == Encoding::kAscii ? parse_ascii(e) : parse_binary(e);
      if (!body) return body.error();
    }
    return std::move(file_);
  }

 private:
  Error at_line(const std::string& what) const {
    return bad_input(path_, "line " + std::to_string(line_number_) + ": " + what);
  }
  Error at_byte(const PlyElement& element, std::size_t instance, const std::string& what) const {
    return bad_input(path_, "element " + element.name + " " + std::to_string(instance) + ", byte " +
                                std::to_string(rest_.data() - begin_) + ": " + what);
  }
  std::string_view take_line() {
    ++line_number_;
    return next_line(rest_);
  }

  Result<void> parse_header() {
    std::string_view magic = take_line();
    if (next_word(magic) != "ply") return bad_input(path_, "not a PLY file (no 'ply' in line 1)");
    if (!next_word(magic).empty())
      return at_line(
          "the header goes on behind 'ply'; each of its entries needs a line of its own");
    bool has_format = false;
    while (!rest_.empty()) {
      std::string_view line = take_line();
      const std::string_view keyword = next_word(line);
      Result<void> parsed;
      if (keyword == "end_header")
        return has_format ? Result<void>() : at_line("the header names no format");
      if (keyword == "format") {
        parsed = parse_format(line);
        has_format = true;
      } else if (keyword == "element") {
        parsed = parse_element(line);
      } else if (keyword == "property") {
        parsed = parse_property(line);
      } else if (keyword == "obj_info") {
        const std::string key(next_word(line));
        file_.object_info[key] = std::string(next_word(line));
      } else if (keyword != "comment" && !next_word(line).empty()) {
        // A word alone declares nothing: copies of Stanford scans have lines `bye`.
        parsed = at_line("unknown header keyword " + quoted(keyword));
      }
      if (!parsed) return parsed;
    }
    return at_line("the file ends inside its header");
  }

  Result<void> parse_format(std::string_view line) {
    const std::string_view name = next_word(line);
    if (name == "ascii")
      encoding_ = Encoding::kAscii;
    else if (name == "binary_little_endian")
      encoding_ = Encoding::kLittleEndian;
    else if (name == "binary_big_endian")
      encoding_ = Encoding::kBigEndian;
    else
      return at_line("unknown format " + quoted(name));
    return {};
  }

  Result<void> parse_element(std::string_view line) {
    PlyElement element;
    element.name = std::string(next_word(line));
    const std::string_view count = next_word(line);
    const auto [end, error] =
        std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (element.name.empty() || count.empty() || error != std::errc() ||
        end != count.data() + count.size())
      return at_line("expected 'element NAME COUNT', found the count " + quoted(count));
    file_.elements.push_back(std::move(element));
    types_.emplace_back();
    return {};
  }

  Result<void> parse_property(std::string_view line) {
    if (file_.elements.empty()) return at_line("a property before the first element");
    PlyProperty property;
    PropertyType type;
    std::string_view type_name = next_word(line);
    if (type_name == "list") {
      property.is_list = true;
      const std::string_view count_name = next_word(line);
      const auto count = type_of(count_name);
      if (!count || *count == Type::kFloat || *count == Type::kDouble)
        return at_line("a list cannot be counted by " + quoted(count_name));
      type.count = *count;
      type_name = next_word(line);
    }
    const auto value = type_of(type_name);
    if (!value) return at_line("unknown property type " + quoted(type_name));
    type.value = *value;
    property.name = std::string(next_word(line));
    if (property.name.empty()) return at_line("a property without a name");
    file_.elements.back().properties.push_back(std::move(property));
    types_.back().push_back(type);
    return {};
  }

  // Before instance i of an element.
  void look_at_memory(std::size_t i) const {
    constexpr std::size_t kBetweenLooks = 4096, kBetweenReleases = std::size_t{1} << 16;
    if (i % kBetweenLooks == 0) check_stop_and_memory();
    if (parsed_ && i % kBetweenReleases == 0)
      parsed_(static_cast<std::size_t>(rest_.data() - begin_));
  }

  // The least number of bytes that one instance of an element takes.
  std::size_t least_bytes(std::size_t e) const {
    std::size_t bytes = 0;
    for (std::size_t p = 0; p < types_[e].size(); ++p) {
      const bool is_list = file_.elements[e].properties[p].is_list;
      if (encoding_ == Encoding::kAscii)
        bytes += 2;  // a digit and what separates it from the next
      else
        bytes += size_of(is_list ? types_[e][p].count : types_[e][p].value);
    }
    return bytes;
  }

  Result<void> reserve(std::size_t e) {
    PlyElement& element = file_.elements[e];
    if (element.properties.empty() && element.count > 0)
      return bad_input(path_, "the header promises " + std::to_string(element.count) +
                                  " of element " + element.name +
                                  " without any property, so the file holds nothing of them; its "
                                  "header is wrong");
    const std::size_t least = least_bytes(e);
    if (least > 0 && element.count > (rest_.size() + 1) / least)
      return bad_input(path_, "the header promises " + std::to_string(element.count) +
                                  " of element " + element.name +
                                  ", but the file ends after at most " +
                                  std::to_string((rest_.size() + 1) / least) +
                                  "; it is truncated or its header is wrong");
    for (auto& property : element.properties) {
      property.values.reserve(element.count);
      if (!property.is_list) continue;
      property.starts.reserve(element.count + 1);
      property.starts.push_back(0);
    }
    return {};
  }

  Result<void> parse_ascii(std::size_t e) {
    PlyElement& element = file_.elements[e];
    for (std::size_t i = 0; i < element.count; ++i) {
      look_at_memory(i);
      std::string_view line = take_line();
      for (std::string_view probe = line; next_word(probe).empty();) {  // skips blank lines
        if (rest_.empty())
          return at_line("the file ends at " + element.name + " " + std::to_string(i) + " of " +
                         std::to_string(element.count) + "; it is truncated");
        probe = line = take_line();
      }
      for (auto& property : element.properties)
        if (auto read = parse_ascii_property(property, line); !read) return read;
      if (const auto extra = next_word(line); !extra.empty())
        return at_line("more values than the header's properties of element " + element.name +
                       ", from " + quoted(extra));
    }
    return {};
  }

  Result<void> parse_ascii_property(PlyProperty& property, std::string_view& line) {
    double value = 0.0;
    if (!property.is_list) {
      if (!take_number(line, value)) return not_a_number(property);
      property.values.push_back(value);
      return {};
    }
    if (!take_number(line, value)) return not_a_number(property);
    // Each value takes at least a space and a digit.
    if (!(value >= 0.0) || value != std::floor(value) ||
        value > static_cast<double>(line.size()) / 2.0)
      return at_line("the list " + property.name + " cannot have " + quoted(last_word_) +
                     " values on this line");
    for (auto left = static_cast<std::size_t>(value); left > 0; --left) {
      if (!take_number(line, value)) return not_a_number(property);
      property.values.push_back(value);
    }
    property.starts.push_back(property.values.size());
    return {};
  }

  bool take_number(std::string_view& line, double& value) {
    last_word_ = next_word(line);
    return parse_number(last_word_, value);
  }

  Error not_a_number(const PlyProperty& property) const {
    return at_line(last_word_.empty() ? "the line ends where " + property.name + " is expected"
                                      : "expected a number for " + property.name + ", found " +
                                            quoted(last_word_));
  }

  Result<void> parse_binary(std::size_t e) {
    PlyElement& element = file_.elements[e];
    for (std::size_t i = 0; i < element.count; ++i) {
      look_at_memory(i);
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        PlyProperty& property = element.properties[p];
        std::size_t length = 1;
        if (property.is_list) {
          const auto count = take_number(types_[e][p].count);
          if (!count) return truncated(element, i);
          if (*count < 0.0) return at_byte(element, i, "a list of negative length");
          length = static_cast<std::size_t>(*count);
          if (length > rest_.size() / size_of(types_[e][p].value)) return truncated(element, i);
        }
        for (; length > 0; --length) {
          const auto value = take_number(types_[e][p].value);
          if (!value) return truncated(element, i);
          property.values.push_back(*value);
        }
        if (property.is_list) property.starts.push_back(property.values.size());
      }
    }
    return {};
  }

  Error truncated(const PlyElement& element, std::size_t instance) const {
    return at_byte(element, instance,
                   "the file ends before its " + std::to_string(element.count) + " " +
                       element.name + "s; it is truncated");
  }

  template <typename T, typename Bits>
  double take(std::size_t size) {
    Bits bits;
    std::memcpy(&bits, rest_.data(), size);
    rest_.remove_prefix(size);
    const bool little = encoding_ == Encoding::kLittleEndian;
    if (little != (std::endian::native == std::endian::little)) {
      if constexpr (sizeof(Bits) == 2) bits = __builtin_bswap16(bits);
      if constexpr (sizeof(Bits) == 4) bits = __builtin_bswap32(bits);
      if constexpr (sizeof(Bits) == 8) bits = __builtin_bswap64(bits);
    }
    return static_cast<double>(std::bit_cast<T>(bits));
  }

  std::optional<double> take_number(Type type) {
    const std::size_t size = size_of(type);
    if (rest_.size() < size) return std::nullopt;
    switch (type) {
      case Type::kInt8:
        return take<std::int8_t, std::uint8_t>(size);
      case Type::kUint8:
        return take<std::uint8_t, std::uint8_t>(size);
      case Type::kInt16:
        return take<std::int16_t, std::uint16_t>(size);
      case Type::kUint16:
        return take<std::uint16_t, std::uint16_t>(size);
      case Type::kInt32:
        return take<std::int32_t, std::uint32_t>(size);
      case Type::kUint32:
        return take<std::uint32_t, std::uint32_t>(size);
      case Type::kFloat:
        return take<float, std::uint32_t>(size);
      case Type::kDouble:
        return take<double, std::uint64_t>(size);
    }
    return std::nullopt;
  }

  const std::filesystem::path& path_;
  const std::function<void(std::size_t)>& parsed_;
  const char* begin_;
  std::string_view rest_;
  std::string_view last_word_;
  std::size_t line_number_ = 0;
  Encoding encoding_ = Encoding::kAscii;
  PlyFile file_;
  std::vector<std::vector<PropertyType>> types_;  // of each element's properties
};

}  // namespace

const PlyProperty* PlyElement::find(std::string_view property) const {
  const auto found = std::find_if(properties.begin(), properties.end(),
                                  [&](const auto& p) { return p.name == property; });
  return found == properties.end() ? nullptr : &*found;
}

const PlyElement* PlyFile::find(std::string_view element) const {
  const auto found = std::find_if(elements.begin(), elements.end(),
                                  [&](const auto& e) { return e.name == element; });
  return found == elements.end() ? nullptr : &*found;
}

Result<PlyFile> parse_ply(std::string_view content, const std::filesystem::path& path,
                          const std::function<void(std::size_t)>& parsed) {
  return PlyParser(content, path, parsed).parse();
}

Result<PlyFile> read_ply(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {  // A pipe, or the error to tell.
    const auto content = read_file(path);
    if (!content) return content.error();
    return parse_ply(*content, path, {});
  }
  const auto file = MappedFile::open(path);
  if (!file) return file.error();
  return parse_ply(file->content(), path, [&](std::size_t end) { file->release_before(end); });
}

}  // namespace relief
