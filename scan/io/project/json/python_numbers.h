#pragma once

#include <string>
#include <string_view>

namespace relief {

/// A JSON text in which the numbers that Python writes and JSON has no word for, NaN, Infinity and
/// -Infinity, are texts: "NaN". Texts and comments stay as they are.
std::string quote_python_numbers(std::string_view text);

/// Whether a text is one of those numbers.
bool is_python_number(std::string_view text);

}  // namespace relief
