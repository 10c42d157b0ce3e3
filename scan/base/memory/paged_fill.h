#pragma once

#include <algorithm>
#include <cstddef>

#include "relief/scan/page_allocator.h"
#include "scan/base/parallel.h"

namespace relief {

/// Values that are appended at once; changes no result.
inline constexpr std::size_t kAppendedAtOnce = 16384;

/// A vector of `count` times `value`. Unlike its constructor this looks at the memory, and for a
/// stop, as loops do (parallel.h).
template <typename T>
PagedVector<T> paged_filled(std::size_t count, const T& value) {
  PagedVector<T> values;
  values.reserve(count);
  while (values.size() < count) {
    check_stop_and_memory();
    values.insert(values.end(), std::min(kAppendedAtOnce, count - values.size()), value);
  }
  return values;
}

/// Appends a range in the same way.
template <typename T, typename Values>
void append_paged(const Values& more, PagedVector<T>& values) {
  for (auto from = more.begin(); from != more.end();) {
    check_stop_and_memory();
    const auto to = from + std::min<std::ptrdiff_t>(kAppendedAtOnce, more.end() - from);
    values.insert(values.end(), from, to);
    from = to;
  }
}

/// A copy of a vector, made in the same way.
template <typename T>
PagedVector<T> paged_copy(const PagedVector<T>& values) {
  PagedVector<T> copy;
  copy.reserve(values.size());
  append_paged(values, copy);
  return copy;
}

}  // namespace relief
