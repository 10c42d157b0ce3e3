#include "scan/io/project/json/python_numbers.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace relief {

namespace {

constexpr std::array<std::string_view, 3> kNumbers = {"NaN", "Infinity", "-Infinity"};

// The length of the text between quotes that `text` begins with, or of a comment; 0 for others.
std::size_t quoted_or_comment(std::string_view text) {
  const auto up_to = [&](std::string_view end, std::size_t from) {
    const std::size_t found = text.find(end, from);
    return found == std::string_view::npos ? text.size() : found + end.size();
  };
  if (text.starts_with("//")) return up_to("\n", 2);
  if (text.starts_with("/*")) return up_to("*/", 2);
  if (!text.starts_with('"')) return 0;
  std::size_t end = 1;
  while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
  return std::min(end + 1, text.size());
}

}  // namespace

std::string quote_python_numbers(std::string_view text) {
  std::string quoted;
  while (!text.empty()) {
    const auto* const number = std::ranges::find_if(
        kNumbers, [&](std::string_view word) { return text.starts_with(word); });
    const bool is_number = number != kNumbers.end();
    const std::size_t length =
        is_number ? number->size() : std::max<std::size_t>(quoted_or_comment(text), 1);
    if (is_number) quoted += '"';
    quoted += text.substr(0, length);
    if (is_number) quoted += '"';
    text.remove_prefix(length);
  }
  return quoted;
}

bool is_python_number(std::string_view text) {
  return std::ranges::find(kNumbers, text) != kNumbers.end();
}

}  // namespace relief
