#pragma once

#include <vector>

extern "C" {
void __asan_init() __attribute__((weak));
void __tsan_init() __attribute__((weak));
}

namespace relief::testing {

/// Whether a sanitizer watches the program. It keeps memory that was freed. Tests cannot tell from
/// their own options: they are compiled without the address sanitizer.
inline bool sanitized() { return __asan_init != nullptr || __tsan_init != nullptr; }

/// Whether the thread sanitizer looks for races, which one run has or has not. To compare the
/// results of several is for the other presets.
inline bool looks_for_races() { return __tsan_init != nullptr; }

/// Of the numbers of threads whose results a test compares: all, or for races the last one alone.
inline std::vector<int> compared_threads(std::vector<int> all) {
  if (looks_for_races()) all.erase(all.begin(), all.end() - 1);
  return all;
}

}  // namespace relief::testing
