#include "scan/base/parallel.h"

#include <atomic>
#include <stdexcept>
#include <stop_token>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "tests/support/result_matchers.h"

namespace relief {
namespace {

TEST(ParallelFor, VisitsEveryItemOnce) {
  for (const int threads : {1, 2, 7}) {
    std::vector<int> visits(1003, 0);
    on_threads(threads, [&] {
      parallel_for(visits.size(), 10, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) ++visits[i];
      });
    });
    EXPECT_EQ(visits, std::vector<int>(1003, 1));
  }
}

TEST(ParallelFor, RethrowsInTheCaller) {
  const auto fail = [](std::size_t, std::size_t) { throw std::runtime_error("body"); };
  EXPECT_THROW(on_threads(4, [&] { parallel_for(100, 1, fail); }), std::runtime_error);
}

TEST(ParallelFor, DoesNothingForNothing) {
  parallel_for(0, 1, [](std::size_t, std::size_t) { FAIL(); });
}

TEST(OnThreads, HoldsForLoopsWithinLoops) {
  EXPECT_EQ(on_threads(3, thread_count), 3);
  std::atomic<int> others{0};
  on_threads(3, [&] {
    parallel_for(20, 1, [&](std::size_t, std::size_t) {
      if (thread_count() != 3) ++others;
      on_threads(1, [&] {
        const auto here = std::this_thread::get_id();
        parallel_for(20, 1, [&](std::size_t, std::size_t) {
          if (thread_count() != 1 || std::this_thread::get_id() != here) ++others;
        });
      });
      // More again within one.
      if (on_threads(1, [] { return on_threads(2, thread_count); }) != 2) ++others;
    });
  });
  EXPECT_EQ(others, 0);
}

TEST(OnThreads, ZeroAreThoseOfTheCaller) {
  EXPECT_EQ(on_threads(2, [] { return on_threads(0, thread_count); }), 2);
}

// A loop long enough that only a stop ends it, on some threads, within another loop.
Result<int> loop_in_loop(const Context& context, std::atomic<int>& begun) {
  return run_in(context, [&]() -> Result<int> {
    parallel_for(1000, 1, [&](std::size_t, std::size_t) {
      parallel_for(1000, 1, [&](std::size_t, std::size_t) {
        ++begun;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      });
    });
    return 1;
  });
}

TEST(RunIn, StopsLoopsFromAnyThread) {
  for (const int threads : {1, 3}) {
    std::stop_source source;
    std::atomic<int> begun{0};
    std::jthread stopper([&] {
      while (begun < 20) std::this_thread::yield();
      source.request_stop();
    });
    EXPECT_THAT(loop_in_loop({.threads = threads, .stop = source.get_token()}, begun),
                HasError(ErrorKind::kInterrupted));
    EXPECT_LT(begun, 1000);
  }
}

TEST(RunIn, EndsWorkThatAsks) {
  std::stop_source source;
  int steps = 0;
  const auto result = run_in({.threads = 1, .stop = source.get_token()}, [&]() -> Result<int> {
    for (; steps < 1000; ++steps) {
      check_stop_and_memory();
      if (steps == 10) source.request_stop();
    }
    return steps;
  });
  EXPECT_THAT(result, HasError(ErrorKind::kInterrupted));
  EXPECT_EQ(steps, 11);
  check_stop_and_memory();  // Nobody asked outside.
}

TEST(RunIn, StopsWhatIsCalledWithAContextOfItsOwn) {
  std::stop_source source;
  source.request_stop();
  std::atomic<int> begun{0};
  const auto result =
      run_in({.stop = source.get_token()}, [&] { return loop_in_loop({.threads = 2}, begun); });
  EXPECT_THAT(result, HasError(ErrorKind::kInterrupted));
  EXPECT_EQ(begun, 0);
}

TEST(RunIn, LeavesTheCallersLoopsAsTheyWere) {
  std::stop_source source;
  source.request_stop();
  std::atomic<int> begun{0};
  EXPECT_FALSE(loop_in_loop({.threads = 1, .stop = source.get_token()}, begun));
  parallel_for(10, 1, [&](std::size_t, std::size_t) { ++begun; });
  EXPECT_EQ(begun, 10);
}

}  // namespace
}  // namespace relief
