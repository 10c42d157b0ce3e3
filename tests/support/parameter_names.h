#pragma once

#include <cctype>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace relief::testing {

/// `text` as a part of the name of a test, which may have letters, digits and underscores. A sign
/// becomes a word: 5 and -5 are two tests.
inline std::string as_test_name(std::string_view text) {
  std::string name;
  bool apart = true;
  for (const char c : text) {
    const bool named = std::isalnum(static_cast<unsigned char>(c)) != 0;
    const std::string_view sign = !apart ? "" : c == '-' ? "minus" : c == '+' ? "plus" : "";
    if ((named || !sign.empty()) && apart && !name.empty()) name += '_';
    name += named ? std::string_view(&c, 1) : sign;
    apart = !named && sign.empty();
  }
  return name;
}

/// Names each parameter of a test suite by what GoogleTest prints of it: (2, "a.ply") is 2_a_ply.
struct PrintedName {
  template <typename Param>
  std::string operator()(const ::testing::TestParamInfo<Param>& info) const {
    return as_test_name(::testing::PrintToString(info.param));
  }
};

}  // namespace relief::testing
