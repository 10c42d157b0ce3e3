#pragma once

extern "C" {
void __asan_init() __attribute__((weak));
void __tsan_init() __attribute__((weak));
}

namespace relief::testing {

/// Whether a sanitizer watches the program. It keeps memory that was freed. Tests cannot tell from
/// their own options: they are compiled without the address sanitizer.
inline bool sanitized() { return __asan_init != nullptr || __tsan_init != nullptr; }

}  // namespace relief::testing
