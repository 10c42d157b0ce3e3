#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "scan/base/loop_threads.h"

namespace relief {

namespace {

thread_local int threads_here = 0;  // 0: one per core.
thread_local bool in_loop = false;  // Loops inside a loop start no further threads.

template <typename T>
class Restored {
 public:
  Restored(T& variable, T value)
      : variable_(variable), before_(std::exchange(variable, std::move(value))) {}
  ~Restored() { variable_ = before_; }
  Restored(const Restored&) = delete;
  Restored& operator=(const Restored&) = delete;

 private:
  T& variable_;
  T before_;
};

}  // namespace

int available_threads() {
  if (threads_here > 0) return threads_here;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void with_available_threads(int threads, const std::function<void()>& work) {
  const Restored restored(threads_here, threads);
  work();
}

void visit_on_threads(std::size_t count, const std::function<void(std::size_t)>& visit) {
  const int threads = available_threads();
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex mutex;
  const auto take_part = [&] {
    const Restored threads_restored(threads_here, threads);
    const Restored loop_restored(in_loop, true);
    try {
      for (std::size_t i = next++; i < count; i = next++) visit(i);
    } catch (...) {
      next = count;
      const std::scoped_lock lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  std::vector<std::jthread> others;
  for (int k = 1; k < threads && !in_loop; ++k) others.emplace_back(take_part);
  take_part();
  others.clear();  // joins
  if (failure) std::rethrow_exception(failure);
}

}  // namespace relief
