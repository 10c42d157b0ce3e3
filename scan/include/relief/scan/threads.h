#pragma once

#include <functional>
#include <optional>
#include <type_traits>

namespace relief {

/// How many threads the loops of this library take when they are called here: the number that the
/// enclosing on_threads() gave, else one per core.
int thread_count();

/// Calls `work` once, with `threads` threads for the loops of this library inside. 0: as many as
/// here already. An exception of `work` is rethrown.
void run_on_threads(int threads, const std::function<void()>& work);

/// The same, and gives what `work` returns. Functions that take no Context run on the threads of
/// their caller: `on_threads(1, [&] { return estimate_range_noise(view); })` starts none. No result
/// depends on the number of threads.
template <typename Work>
std::invoke_result_t<const Work&> on_threads(int threads, const Work& work) {
  using Value = std::invoke_result_t<const Work&>;
  if constexpr (std::is_void_v<Value>) {
    run_on_threads(threads, work);
  } else {
    std::optional<Value> value;
    run_on_threads(threads, [&] { value.emplace(work()); });
    return *std::move(value);
  }
}

}  // namespace relief
