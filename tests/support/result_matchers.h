#pragma once

#include <algorithm>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/scan/result.h"

namespace relief {

namespace testing {

inline const char* name_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kBadInput:
      return "kBadInput";
    case ErrorKind::kUnsolvable:
      return "kUnsolvable";
    case ErrorKind::kCannotWrite:
      return "kCannotWrite";
    case ErrorKind::kInterrupted:
      return "kInterrupted";
  }
  return "unknown kind";
}

/// Fails the test with `message` at a place in the source and ends it, in functions that return
/// something as well.
[[noreturn]] inline void end_test(const std::string& message, const char* file, int line) {
  ADD_FAILURE_AT(file, line) << message;
  throw ::testing::AssertionException(::testing::TestPartResult(
      ::testing::TestPartResult::kFatalFailure, file, line, message.c_str()));
}

/// The value of `result`. Without one the test fails with the error's message and ends there.
template <typename T>
T value_of(Result<T> result, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (!result.ok()) end_test(result.error().message, file, line);
  return std::move(result).value();
}

/// The value of `optional`. Without one the test fails and ends there.
template <typename T>
T value_of(std::optional<T> optional, const char* file = __builtin_FILE(),
           int line = __builtin_LINE()) {
  if (!optional) end_test("there is no value", file, line);
  return *std::move(optional);
}

/// Matches a result that has a value.
class IsOk {
 public:
  using is_gtest_matcher = void;

  template <typename T>
  bool MatchAndExplain(const Result<T>& result, std::ostream*) const {
    return result.ok();
  }
  void DescribeTo(std::ostream* out) const { *out << "has a value"; }
  void DescribeNegationTo(std::ostream* out) const { *out << "has an error"; }
};

/// Matches an error: of any kind, or of `kind`, whose message holds all the `parts`.
class HasError {
 public:
  using is_gtest_matcher = void;

  template <typename... Parts>
  explicit HasError(ErrorKind kind, Parts... parts) : kind_(kind), parts_{std::move(parts)...} {}
  template <typename... Parts>
  explicit HasError(Parts... parts) : parts_{std::move(parts)...} {}

  template <typename T>
  bool MatchAndExplain(const Result<T>& result, std::ostream* out) const {
    if (result.ok()) return false;
    const auto& [kind, message] = result.error();
    if (kind_ && kind != *kind_) {
      if (out) *out << "which is of another kind";
      return false;
    }
    for (const std::string& part : parts_) {
      if (message.find(part) != std::string::npos) continue;
      if (out) *out << "which does not say \"" << part << '"';
      return false;
    }
    return true;
  }
  void DescribeTo(std::ostream* out) const {
    *out << "has an error";
    if (kind_) *out << " of kind " << name_of(*kind_);
    for (const std::string& part : parts_)
      *out << (&part == parts_.data() ? " that says \"" : " and \"") << part << '"';
  }
  void DescribeNegationTo(std::ostream* out) const {
    *out << "not: ";
    DescribeTo(out);
  }

 private:
  std::optional<ErrorKind> kind_;
  std::vector<std::string> parts_;
};

}  // namespace testing

// Without a using declaration in nearly every test.
using testing::HasError;
using testing::IsOk;
using testing::value_of;

/// How GoogleTest prints a result.
template <typename T>
void PrintTo(const Result<T>& result, std::ostream* out) {
  if (result.ok()) {
    *out << "a value";
  } else {
    *out << testing::name_of(result.error().kind) << ": \"" << result.error().message << '"';
  }
}

}  // namespace relief
