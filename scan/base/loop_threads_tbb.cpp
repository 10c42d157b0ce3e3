#include <optional>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "scan/base/loop_threads.h"

namespace relief {

int available_threads() { return tbb::this_task_arena::max_concurrency(); }

void with_available_threads(int threads, const std::function<void()>& work) {
  // Threads come from one pool for the whole program, which grows beyond the number of cores only
  // when it is asked to.
  std::optional<tbb::global_control> more;
  if (threads > tbb::info::default_concurrency())
    more.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena(threads).execute(work);
}

void visit_on_threads(std::size_t count, const std::function<void(std::size_t)>& visit) {
  // Isolated: while a thread waits for the end of a loop inside a visit, it must not take up
  // another visit of the loop around it.
  tbb::this_task_arena::isolate(
      [&] { tbb::parallel_for(std::size_t{0}, count, visit, tbb::simple_partitioner{}); });
}

}  // namespace relief
