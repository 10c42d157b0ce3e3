#pragma once

#include <cmath>
#include <string>

#include <CLI/CLI.hpp>

namespace relief {

/// Checks of the numbers of options. CLI11's own write out the largest double, with 309 digits.
inline CLI::Validator number_check(const std::string& what, bool (*holds)(double),
                                   const std::string& shown) {
  return CLI::Validator(
      [what, holds](std::string& text) {
        double value = 0.0;
        const bool fits =
            CLI::detail::lexical_cast(text, value) && std::isfinite(value) && holds(value);
        return fits ? std::string() : "'" + text + "' is no " + what;
      },
      shown);
}

inline CLI::Validator positive_number() {
  return number_check(
      "positive number", [](double value) { return value > 0.0; }, "POSITIVE");
}

inline CLI::Validator nonnegative_number() {
  return number_check(
      "number from 0 up", [](double value) { return value >= 0.0; }, "NONNEGATIVE");
}

}  // namespace relief
