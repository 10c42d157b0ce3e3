#include "scan/base/memory/memory_watch.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <stop_token>

#include "scan/base/memory/memory_limit.h"

namespace relief {

namespace {

using std::chrono::microseconds;

// Two threads that read scattered pages bring so much, as a page brings 15 others [bytes per us].
constexpr std::size_t kBroughtInMicrosecond = std::size_t{60} << 10;

// Between two looks at the memory: not so often that looking takes time, and often enough for
// threads that start meanwhile.
constexpr microseconds kShortest{500}, kLongest{5000};

// The same where handing pages back cannot make room: work is not held up for nothing.
constexpr microseconds kPauseWithoutRoom{1'000'000};

// Until threads may have filled `room` [bytes].
microseconds pause_for(std::size_t room) {
  return std::clamp(microseconds(room / kBroughtInMicrosecond), kShortest, kLongest);
}

void keep(MemoryLimit& limit, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  while (!stop.stop_requested()) {
    std::size_t room = limit.room_for_loops();
    if (room == 0) {
      limit.evict();
      room = limit.room_for_loops();
    }
    const bool waits = room == 0 && !limit.can_make_room_for_loops();
    const microseconds pause = waits ? kPauseWithoutRoom : pause_for(room);
    std::unique_lock lock(mutex);
    stopped.wait_for(lock, stop, pause, [] { return false; });
  }
}

}  // namespace

MemoryWatch::MemoryWatch(MemoryLimit& limit)
    : thread_([&limit](const std::stop_token& stop) { keep(limit, stop); }) {}

}  // namespace relief
