#include "scan/base/parallel.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "relief/scan/context.h"
#include "scan/base/loop_threads.h"
#include "scan/base/memory/memory_limit.h"
#include "scan/base/memory/memory_watch.h"

namespace relief {

namespace {

// How the loops of a thread run. Threads that help in a loop take over the state of the thread that
// began it.
struct LoopState {
  // Loops start no threads. A flag rather than an arena of one place: threads that share an arena
  // would wait for each other.
  bool serial = false;
  const std::stop_token* stop = nullptr;  // Null: nobody asks them to stop.
  MemoryLimit* memory = nullptr;          // Null: there is no limit.
};

thread_local LoopState loop_state;

class LoopStateScope {
 public:
  explicit LoopStateScope(const LoopState& state) : before_(std::exchange(loop_state, state)) {}
  ~LoopStateScope() { loop_state = before_; }
  LoopStateScope(const LoopStateScope&) = delete;
  LoopStateScope& operator=(const LoopStateScope&) = delete;

 private:
  LoopState before_;
};

// Ends the loops that have been asked to stop; never leaves run_until_stopped().
struct Stopped {};

void throw_if_stopped(const LoopState& state) {
  if (state.stop && state.stop->stop_requested()) throw Stopped();
}

// Before each piece of a loop.
void check_stop_and_memory(const LoopState& state) {
  throw_if_stopped(state);
  if (state.memory) state.memory->evict_in_time();
}

// Null where the context has no limit, or an enclosing one has, which holds.
std::shared_ptr<MemoryLimit> new_limit(const Context& context) {
  if (context.memory == 0 || loop_state.memory) return nullptr;
  return std::make_shared<MemoryLimit>(context.memory, context.temporary_folder);
}

}  // namespace

int thread_count() { return loop_state.serial ? 1 : available_threads(); }

void run_on_threads(int threads, const std::function<void()>& work) {
  if (threads <= 0 || threads == thread_count()) return work();
  const LoopState state{threads == 1, loop_state.stop, loop_state.memory};
  const auto run = [&] {
    const LoopStateScope scope(state);
    work();
  };
  if (state.serial) return run();
  with_available_threads(threads, run);
}

bool run_until_stopped(const Context& context, const std::function<void()>& work) {
  LoopState state = loop_state;
  if (context.stop.stop_possible()) state.stop = &context.stop;
  const std::shared_ptr<MemoryLimit> limit = new_limit(context);  // Grids made inside may keep it.
  std::optional<MemoryWatch> watch;
  if (limit) {
    state.memory = limit.get();
    watch.emplace(*limit);
  }
  const LoopStateScope scope(state);
  try {
    run_on_threads(context.threads, work);
  } catch (const Stopped&) {
    return false;
  }
  return true;
}

void check_stop_and_memory() { check_stop_and_memory(loop_state); }

MemoryLimit* current_memory_limit() { return loop_state.memory; }

void release_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) {
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t ranges = (count + grain - 1) / grain;
  const LoopState state = loop_state;
  const auto run = [&](std::size_t range) {
    check_stop_and_memory(state);
    body(range * grain, std::min(count, (range + 1) * grain));
  };
  if (ranges <= 1 || thread_count() == 1) {
    for (std::size_t range = 0; range < ranges; ++range) run(range);
    return;
  }
  visit_on_threads(ranges, [&](std::size_t range) {
    const LoopStateScope scope(state);
    run(range);
  });
}

}  // namespace relief
