#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>

#include "scan/base/parallel.h"

namespace relief {

/// Computes the values `compute(0)` to `compute(count - 1)` as parallel_map() does, at most
/// `at_once` before the next, and calls `take(i, value)` for each in this order, in this thread. So
/// no more than `at_once` of them are held. `at_once` (>= 1) changes no result.
template <typename Value, typename Compute, typename Take>
void parallel_map_in_batches(std::size_t count, std::size_t at_once, const Compute& compute,
                             const Take& take) {
  for (std::size_t first = 0; first < count; first += at_once) {
    auto values = parallel_map<Value>(std::min(at_once, count - first),
                                      [&](std::size_t i) { return compute(first + i); });
    for (std::size_t i = 0; i < values.size(); ++i) take(first + i, std::move(values[i]));
  }
}

}  // namespace relief
