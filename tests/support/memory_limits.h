#pragma once

#include <cstddef>

namespace relief::testing {

inline constexpr std::size_t kMebibyte = std::size_t{1} << 20;

/// For a limit of 100 MiB: every call of MemoryLimit::evict_pages() finds the process near it, and
/// then far below it. It asks three times: before and after it takes the lock, and when pages were
/// handed back.
inline std::size_t always_near_the_limit() {
  thread_local std::size_t questions = 0;
  return questions++ % 3 == 2 ? kMebibyte : 99 * kMebibyte;
}

}  // namespace relief::testing
