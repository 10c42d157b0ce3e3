#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace relief {

inline std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return text;
}

/// The ending of a file name with its dot, in lower case: programs and cameras of other systems
/// write `SCAN01.PLY`. Empty where there is none.
inline std::string lower_ending(const std::filesystem::path& path) {
  return lower_case(path.extension().string());
}

}  // namespace relief
