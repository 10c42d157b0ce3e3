#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace relief {

/// The ending of a file name with its dot, in lower case: programs and cameras of other systems
/// write `SCAN01.PLY`. Empty where there is none.
inline std::string lower_ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return ending;
}

}  // namespace relief
