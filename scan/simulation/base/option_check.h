#pragma once

#include <cmath>
#include <initializer_list>
#include <sstream>

#include "relief/scan/result.h"

namespace relief::simulation {

/// Success if `holds`, else kBadInput that names the option, its value and the constraint.
inline Result<void> require(bool holds, const char* option, double value, const char* constraint) {
  if (holds) return {};
  std::ostringstream message;
  message << "simulation option " << option << " is " << value << "; it must be " << constraint;
  return Error{ErrorKind::kBadInput, message.str()};
}

inline Result<void> require_not_negative(const char* option, double value) {
  return require(std::isfinite(value) && value >= 0.0, option, value, "0 or more");
}

inline Result<void> require_positive(const char* option, double value) {
  return require(std::isfinite(value) && value > 0.0, option, value, "positive");
}

inline Result<void> first_failure(std::initializer_list<Result<void>> checks) {
  for (const Result<void>& check : checks)
    if (!check) return check;
  return {};
}

}  // namespace relief::simulation
