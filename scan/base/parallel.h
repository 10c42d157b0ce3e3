#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "relief/scan/context.h"

namespace relief {

/// Calls `body(begin, end)` on consecutive ranges of [0, count) of at most `grain` items each, on
/// the threads of the caller (on_threads). The ranges depend on `count` and `grain` only, never on
/// the number of threads, so a body that writes per item or per range gives the same bytes always.
/// An exception of a body is rethrown in the caller after all threads have stopped.
void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Ends the computation of the enclosing run_in() when somebody asked it to stop, and keeps to its
/// memory limit, as each piece of a loop above does. For long work on one thread, at least once in
/// about a tenth of a second, and under a limit before some megabytes of paged arrays are touched.
void check_stop_and_memory();

/// Calls `body(i)` for each i of [0, count), in this thread and in this order, and looks now and
/// then as above.
template <typename Body>
void serial_for(std::size_t count, const Body& body) {
  constexpr std::size_t kBetweenLooks = 4096;  // Changes no result.
  for (std::size_t begin = 0; begin < count; begin += kBetweenLooks) {
    check_stop_and_memory();
    const std::size_t end = std::min(count, begin + kBetweenLooks);
    for (std::size_t i = begin; i < end; ++i) body(i);
  }
}

/// Gives memory that loops' threads have freed, which the C library keeps for each of them, back to
/// the system as far as it can. Worth it after loops that made large parts of a result.
void release_freed_memory();

/// The values `compute(0)` to `compute(count - 1)`, one at a time for each thread: for few and
/// large ones.
template <typename Value, typename Compute>
std::vector<Value> parallel_map(std::size_t count, const Compute& compute) {
  std::vector<Value> values(count);
  parallel_for(count, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) values[i] = compute(i);
  });
  return values;
}

/// Calls `body(v)` for every row v of [0, rows) of a grid, some rows at a time, as above.
template <typename Body>
void parallel_rows(int rows, const Body& body) {
  constexpr std::size_t kRowsAtOnce = 16;  // Shares the cost of a piece; changes no result.
  parallel_for(static_cast<std::size_t>(rows), kRowsAtOnce,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t v = begin; v < end; ++v) body(static_cast<int>(v));
               });
}

/// The sum of `term(begin, end)` over ranges of [0, count) as above, in their order: the same bytes
/// for any number of threads.
template <typename T, typename Term>
T parallel_sum(std::size_t count, std::size_t grain, const T& zero, const Term& term) {
  grain = std::max<std::size_t>(grain, 1);
  std::vector<T> parts((count + grain - 1) / grain, zero);
  parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
    parts[begin / grain] = term(begin, end);
  });
  T sum = zero;
  for (const T& part : parts) sum += part;
  return sum;
}

}  // namespace relief
