#pragma once

#include <filesystem>
#include <string>

namespace relief::testing {

/// A file or folder of the real test scans; empty when they are absent. The environment variable
/// RELIEF_TEST_DATA wins over the place configured at build time.
std::filesystem::path test_data(const std::string& name);

}  // namespace relief::testing

/// Binds `variable` to the path of real scans, or skips the test, visibly, where they are absent.
#define RELIEF_REQUIRE_TEST_DATA(variable, name)                    \
  const auto variable = relief::testing::test_data(name);           \
  if (variable.empty()) GTEST_SKIP() << "no test data: " << (name); \
  static_assert(true)
