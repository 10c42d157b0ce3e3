#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string_view>
#include <type_traits>
#include <utility>

#include "relief/scan/result.h"

namespace relief {

class UnitStore;

/// Told how far a long computation is: `fraction` in [0, 1] of the step named by `step`.
/// Returning false asks the computation to stop; it then returns ErrorKind::kInterrupted.
/// Called from the thread that started the computation only.
using Progress = std::function<bool(double fraction, std::string_view step)>;

/// Calls `progress` if there is one; true means go on.
inline bool report_progress(const Progress& progress, double fraction, std::string_view step) {
  return !progress || progress(fraction, step);
}

/// How a long computation is carried out: what it may take, and whom it tells. Options say what is
/// computed. Of a context only `seed` may change a result.
struct Context {
  int threads = 0;  ///< See on_threads(); 0: those of the caller, else one per core.
  /// Resident memory of the process to keep to [bytes], 0: no limit. Grids that do not fit lie in
  /// temporary files (page_allocator.h). Functions that work in files otherwise, or on fewer views
  /// at a time, say how they heed it. Inside of a run_in() with a limit that limit holds.
  std::size_t memory = 0;
  std::filesystem::path temporary_folder;  ///< For such files; empty: TMPDIR, or /tmp.
  std::uint64_t seed = 1;                  ///< Of everything random.
  /// What earlier computations have finished is taken from here, and what is finished is kept here
  /// (unit_store.h); null: all is computed. The result is the same to the bit.
  UnitStore* store = nullptr;
  Progress progress;  ///< Empty: nobody is told.
  /// Asks the computation to stop, from any thread. It then returns ErrorKind::kInterrupted at the
  /// end of what its loops have begun, as when `progress` returns false.
  std::stop_token stop;

  /// The same with another reader of the progress.
  Context with_progress(Progress other) const {
    Context context = *this;
    context.progress = std::move(other);
    return context;
  }
};

/// Calls `work` on the threads of a context. False when the context stopped a loop inside.
bool run_until_stopped(const Context& context, const std::function<void()>& work);

/// The same for work that gives a Result: kInterrupted when the context stopped it.
template <typename Work>
std::invoke_result_t<const Work&> run_in(const Context& context, const Work& work) {
  std::optional<std::invoke_result_t<const Work&>> result;
  if (!run_until_stopped(context, [&] { result.emplace(work()); }))
    return Error{ErrorKind::kInterrupted, "stopped on request"};
  return *std::move(result);
}

/// How many threads the loops of this library take when they are called here: the number that the
/// enclosing on_threads() gave, else one per core.
int thread_count();

/// Calls `work` once, with `threads` threads for the loops of this library inside. 0: as many as
/// here already. An exception of `work` is rethrown.
void run_on_threads(int threads, const std::function<void()>& work);

/// The same, and gives what `work` returns. Functions that take no Context run on the threads of
/// their caller: `on_threads(1, [&] { return connect_samples(view); })` starts none. No result
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
