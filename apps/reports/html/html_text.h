#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace relief {

/// `text` as it must stand in HTML, in an attribute or between tags, to appear as it is.
std::string escape_html(std::string_view text);

/// JSON as it may stand inside a <script>: no character of it can end the script.
std::string escape_script_json(std::string_view json);

/// The bytes in base64, with padding.
std::string base64(std::string_view bytes);

/// The values as bytes in base64, least significant byte first.
template <typename T>
std::string base64_of(const std::vector<T>& values) {
  return base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

/// `page` with each `{{name}}` replaced by the value of that name. Values are not looked through
/// again, so that they may hold braces. A name without value is a caller's bug.
std::string fill_template(std::string_view page,
                          const std::map<std::string, std::string, std::less<>>& values);

/// A term and what it is, as an entry of a <dl>.
std::string list_entry(std::string_view term, std::string_view html);

/// HTML that scrolls sideways where the page is too narrow. `label` tells a screen reader what it
/// is.
std::string scrolling_region(std::string_view label, std::string_view html);

/// A count with narrow spaces between its groups of three digits.
std::string grouped(std::uint64_t count);

/// Names as a list in words: "a, b and c"; of more than `limit`, the first and how many more.
std::string list_in_words(const std::vector<std::string>& names, std::size_t limit = 8);

}  // namespace relief
