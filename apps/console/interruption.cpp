#include "apps/console/interruption.h"

#include <atomic>
#include <csignal>
#include <thread>

namespace relief {

namespace {

std::atomic<bool> over{false};  // The time limit.

std::stop_source& source() {
  static std::stop_source instance;
  return instance;
}

sigset_t signals_to_catch() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

// In a thread of its own: hardly anything may be called from a signal handler.
void wait_for_signals() {
  const sigset_t signals = signals_to_catch();
  int signal = 0;
  sigwait(&signals, &signal);
  source().request_stop();
  sigwait(&signals, &signal);
  std::signal(signal, SIG_DFL);
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  std::raise(signal);
}

}  // namespace

void catch_interrupts() {
  source();
  const sigset_t signals = signals_to_catch();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread(wait_for_signals).detach();
}

void stop_after(std::chrono::duration<double> limit) {
  std::thread([limit] {
    std::this_thread::sleep_for(limit);
    over = true;
    source().request_stop();
  }).detach();
}

bool time_is_over() { return over; }

std::stop_token interruption() { return source().get_token(); }

}  // namespace relief
