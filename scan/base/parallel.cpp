#include "scan/base/parallel.h"

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace relief {

namespace {

// A place for so many threads to work in, the caller among them. Made once: that takes as long as
// many a loop. Threads come from one pool for the whole program, which grows to what is asked for
// even beyond the number of cores.
class Arena {
 public:
  static tbb::task_arena& of(int threads) {
    static std::mutex mutex;
    static std::map<int, std::unique_ptr<Arena>> all;
    const std::scoped_lock lock(mutex);
    std::unique_ptr<Arena>& arena = all[threads];
    if (!arena) arena = std::make_unique<Arena>(threads);
    return arena->arena_;
  }

  explicit Arena(int threads) : arena_(threads) {
    if (threads > thread_count(0))
      more_ = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<std::size_t>(threads));
  }

 private:
  std::unique_ptr<tbb::global_control> more_;
  tbb::task_arena arena_;
};

}  // namespace

int thread_count(int requested) {
  if (requested > 0) return requested;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void release_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t, std::size_t)>& body) {
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t ranges = (count + grain - 1) / grain;
  const auto run = [&](std::size_t range) {
    body(range * grain, std::min(count, (range + 1) * grain));
  };
  const int workers = thread_count(threads);
  if (workers == 1 || ranges <= 1) {
    for (std::size_t range = 0; range < ranges; ++range) run(range);
    return;
  }
  // Isolated: while a thread waits for the end of a loop inside a body, it must not take up another
  // range of the loop around it.
  Arena::of(workers).execute([&] {
    tbb::this_task_arena::isolate(
        [&] { tbb::parallel_for(std::size_t{0}, ranges, run, tbb::simple_partitioner{}); });
  });
}

}  // namespace relief
