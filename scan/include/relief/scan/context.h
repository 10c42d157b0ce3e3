#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <type_traits>
#include <utility>

#include "relief/scan/progress.h"
#include "relief/scan/result.h"
#include "relief/scan/threads.h"

namespace relief {

class UnitStore;

/// How a long computation is carried out: what it may take, and whom it tells. Options say what is
/// computed. Of a context only `seed` may change a result.
struct Context {
  int threads = 0;  ///< See on_threads(); 0: those of the caller, else one per core.
  /// Memory to keep to [bytes], 0: no limit. Functions that can work in files, or on fewer views at
  /// a time, say how they heed it.
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

}  // namespace relief
