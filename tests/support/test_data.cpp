#include "tests/support/test_data.h"

#include <cstdlib>

namespace relief::testing {

std::filesystem::path test_data(const std::string& name) {
  const char* folder = std::getenv("RELIEF_TEST_DATA");
  const auto path = std::filesystem::path(folder ? folder : RELIEF_TEST_DATA) / name;
  return std::filesystem::exists(path) ? path : std::filesystem::path();
}

}  // namespace relief::testing
