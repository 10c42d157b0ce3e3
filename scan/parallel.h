#pragma once

#include <cstddef>
#include <functional>

namespace relief {

/// The number of threads that `requested` stands for: itself when positive, else one per core.
int thread_count(int requested);

/// Calls `body(begin, end)` on consecutive ranges of [0, count) of at most `grain` items each, from
/// `threads` threads (0: one per core). The ranges depend on `count` and `grain` only, never on the
/// number of threads, so a body that writes per item or per range gives the same bytes always.
/// An exception of a body is rethrown in the caller after all threads have stopped.
void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Calls `body(v)` for every row v of [0, rows) of a grid, some rows at a time, as above.
template <typename Body>
void parallel_rows(int rows, int threads, const Body& body) {
  constexpr std::size_t kRowsAtOnce = 16;
  parallel_for(static_cast<std::size_t>(rows), kRowsAtOnce, threads,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t v = begin; v < end; ++v) body(static_cast<int>(v));
               });
}

}  // namespace relief
