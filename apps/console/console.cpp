#include "apps/console/console.h"

#include <atomic>
#include <csignal>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

namespace relief {

namespace {

std::atomic<bool> interrupted{false};
bool bar_open = false;  // a progress bar stands on the terminal's current line

void on_signal(int signal) {
  if (interrupted.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

spdlog::logger& logger() {
  static const std::shared_ptr<spdlog::logger> instance = [] {
    auto created = std::make_shared<spdlog::logger>(
        "relief", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    created->set_pattern("%^%v%$");
    return created;
  }();
  return *instance;
}

void close_bar() {
  if (bar_open) fmt::print(stderr, "\n");
  bar_open = false;
}

bool quiet() { return logger().level() > spdlog::level::info; }

void draw_bar(const std::string& stage, double fraction, std::string_view step) {
  constexpr int kWidth = 30;
  const int filled = static_cast<int>(fraction * kWidth);
  fmt::print(stderr, "\r{:<11} [{:=<{}}{:<{}}] {:3.0f} % {:<32.32}", stage, "", filled, "",
             kWidth - filled, 100.0 * fraction, step);
  std::fflush(stderr);
  bar_open = true;
  if (fraction >= 1.0) close_bar();
}

}  // namespace

void Console::set_verbosity(Verbosity verbosity) {
  logger().set_level(verbosity == Verbosity::kQuiet     ? spdlog::level::err
                     : verbosity == Verbosity::kVerbose ? spdlog::level::debug
                                                        : spdlog::level::info);
}

void Console::info(const std::string& message) {
  close_bar();
  logger().info("{}", message);
}

void Console::detail(const std::string& message) {
  close_bar();
  logger().debug("{}", message);
}

void Console::warning(const std::string& message) {
  close_bar();
  logger().warn("warning: {}", message);
}

void Console::error(const std::string& message) {
  close_bar();
  logger().error("error: {}", message);
}

Progress console_progress(const std::string& stage) {
  const bool terminal = isatty(STDERR_FILENO) != 0;
  auto last_quarter = std::make_shared<int>(-1);
  auto last_step = std::make_shared<std::string>();
  return [=](double fraction, std::string_view step) {
    if (interrupted) return false;
    if (quiet()) return true;
    if (terminal) {
      draw_bar(stage, fraction, step);
    } else if (const int quarter = static_cast<int>(fraction * 4);
               quarter != *last_quarter || step != *last_step) {
      logger().debug("{}: {:.0f} % {}", stage, 100.0 * fraction, step);
      if (quarter > *last_quarter && step == *last_step)
        logger().info("{}: {:.0f} % {}", stage, 100.0 * fraction, step);
      *last_quarter = quarter;
      *last_step = step;
    }
    return true;
  };
}

reconstruction::StageProgress console_stage_progress() {
  std::map<reconstruction::Stage, Progress> progress;
  return [progress](reconstruction::Stage stage, double fraction, std::string_view step) mutable {
    Progress& of_stage = progress[stage];
    if (!of_stage) of_stage = console_progress(std::string(to_string(stage)));
    return of_stage(fraction, step);
  };
}

void catch_interrupts() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

}  // namespace relief
