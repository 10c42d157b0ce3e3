#pragma once

#include <charconv>
#include <cstddef>
#include <istream>
#include <string>
#include <string_view>

namespace relief {

inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}

/// Takes the next word off a line; empty at its end.
inline std::string_view next_word(std::string_view& line) {
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  std::size_t length = 0;
  while (length < line.size() && !is_blank(line[length])) ++length;
  const std::string_view word = line.substr(0, length);
  line.remove_prefix(length);
  return word;
}

/// Takes the next line, without its end, off a text. A line ends in a line feed, in a carriage
/// return as on classic Macs, or in both. Of two returns before a line feed, as transfers of files
/// in text mode leave them, the second is no further line.
inline std::string_view next_line(std::string_view& text) {
  std::size_t end = 0;
  while (end < text.size() && text[end] != '\n' && text[end] != '\r') ++end;
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end);
  for (const std::string_view ending : {"\r\r\n", "\r\n", "\r", "\n"}) {
    if (!text.starts_with(ending)) continue;
    text.remove_prefix(ending.size());
    break;
  }
  return line;
}

/// Reads the next line off a file; false at its end. Lines end as those of next_line(), but each of
/// two returns before a line feed ends one.
inline bool read_line(std::istream& file, std::string& line) {
  line.clear();
  char c = 0;
  while (file.get(c)) {
    if (c == '\r' && file.peek() == '\n') continue;
    if (c == '\n' || c == '\r') return true;
    line += c;
  }
  return !line.empty();
}

/// A text without the mark that some editors put before UTF-8.
inline std::string_view without_byte_order_mark(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  return text;
}

/// Whether the whole of `word` is a number, which `value` then holds. Numbers too small for a
/// double are 0; `nan` and `inf` are numbers.
inline bool parse_number(std::string_view word, double& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range) value = 0.0;
  return !word.empty() && error != std::errc::invalid_argument && end == word.data() + word.size();
}

}  // namespace relief
